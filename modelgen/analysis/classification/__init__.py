"""What kind of motion it is: periodic, quasi-periodic or chaotic, and which evidence says so.

``verdict`` weighs the evidence (``sequence_tests`` on the points of a section, exponents, orbits); ``motion_evidence`` gathers
it all for a case and several starts, with ``groups`` and ``damping``. Below ``stability`` and ``nonlinear``.
"""
