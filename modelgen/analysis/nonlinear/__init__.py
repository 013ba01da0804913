"""The settled motion of the nonlinear model, and how it changes with parameters.

``strobes`` looks at a motion once per ``common_period`` until it comes back (``recurrence``); ``runs`` and ``motion`` (without
the rigid rotation) are under everything here. Drawn from it: ``sections`` (Poincaré) and ``surface``, ``bifurcation``,
``frequency_sweep``; ``maps`` measures whole windows instead. Below ``linear`` and ``time_domain``.
"""
