"""Questions: one per file, each a function from a model or a solution to a result that ``plots`` can draw.

Rooms, in the order of the flow; a room imports only from those before it:

    linear          modes, Campbell diagram, sensitivities, forced response: the model about an operating point
    time_domain     a run over time: when it is settled, torsional angles, mesh forces
    nonlinear       the settled motion: strobes, Poincaré sections, bifurcation diagrams, frequency sweeps, maps
    stability       periodic orbits with Floquet multipliers, Lyapunov exponents
    classification  periodic, quasi-periodic or chaotic, and which evidence says so
    limits          results against rules of classification societies and standards
    measurements    recorded channels over a run
    referee         an independent engine over a run
    sweeps          many points of one case, on all cores or a cluster

The last three need no other room. What is asked for most is importable from here; the rest from the file that defines it.
"""

from modelgen.analysis.classification.motion_evidence import MotionEvidence, motion_evidence
from modelgen.analysis.classification.verdict import Verdict, classify
from modelgen.analysis.linear.campbell import CampbellResult, CriticalSpeed, OrderLine, campbell
from modelgen.analysis.linear.forced import ForcedResult, Swings, forced
from modelgen.analysis.linear.frequency_response import frequency_response
from modelgen.analysis.linear.gear_hammer import GearLoad, HammerResult, gear_hammer
from modelgen.analysis.linear.modal import ModalResult, modal
from modelgen.analysis.linear.phase_vectors import PhaseVectorResult, phase_vectors
from modelgen.analysis.linear.sensitivity import SensitivityResult, sensitivities
from modelgen.analysis.nonlinear.bifurcation import BifurcationResult, Column, bifurcation
from modelgen.analysis.nonlinear.frequency_sweep import FrequencySweepResult, frequency_sweep
from modelgen.analysis.nonlinear.maps import MapResult, operating_map
from modelgen.analysis.nonlinear.sections import SectionResult, poincare
from modelgen.analysis.stability.exponents import ExponentsResult, lyapunov_exponents
from modelgen.analysis.stability.orbits import PeriodicOrbit, periodic_orbit
from modelgen.analysis.sweeps.result import SweepResult
from modelgen.analysis.sweeps.sweep import sweep
from modelgen.analysis.time_domain.angles import AnglesResult, angles
from modelgen.analysis.time_domain.settled import SettledResult, settled
from modelgen.analysis.time_domain.window import Window, settled_window

__all__ = [
    "AnglesResult",
    "BifurcationResult",
    "CampbellResult",
    "Column",
    "CriticalSpeed",
    "ExponentsResult",
    "ForcedResult",
    "FrequencySweepResult",
    "GearLoad",
    "HammerResult",
    "MapResult",
    "ModalResult",
    "MotionEvidence",
    "OrderLine",
    "PeriodicOrbit",
    "PhaseVectorResult",
    "SectionResult",
    "SensitivityResult",
    "SettledResult",
    "SweepResult",
    "Swings",
    "Verdict",
    "Window",
    "angles",
    "bifurcation",
    "campbell",
    "classify",
    "forced",
    "frequency_response",
    "frequency_sweep",
    "gear_hammer",
    "lyapunov_exponents",
    "modal",
    "motion_evidence",
    "operating_map",
    "periodic_orbit",
    "phase_vectors",
    "poincare",
    "sensitivities",
    "settled",
    "settled_window",
    "sweep",
]
