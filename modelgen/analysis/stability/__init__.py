"""Whether what lies near a motion comes back to it: periodic ``orbits`` and ``multipliers`` (Floquet), ``exponents`` (Lyapunov).

Both carry deviations along a motion: ``variational`` equations in vibrating ``coordinates``, over a ``course``, by
``propagators``. ``shooting`` finds orbits, ``frames`` and ``interval`` make exponents and say how sure they are.
Below ``nonlinear``.
"""
