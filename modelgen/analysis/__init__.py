"""Questions: one per file, each a function from a model or a solution to a result that ``plots`` can draw."""

from modelgen.analysis.angles import AnglesResult, angles
from modelgen.analysis.bifurcation import BifurcationResult, Column, bifurcation
from modelgen.analysis.campbell import CampbellResult, CriticalSpeed, OrderLine, campbell
from modelgen.analysis.classification import Verdict, classify
from modelgen.analysis.exponents import ExponentsResult, lyapunov_exponents
from modelgen.analysis.forced import ForcedResult, Swings, forced
from modelgen.analysis.frequency_response import frequency_response
from modelgen.analysis.frequency_sweep import FrequencySweepResult, frequency_sweep
from modelgen.analysis.gear_hammer import GearLoad, HammerResult, gear_hammer
from modelgen.analysis.maps import MapResult, operating_map
from modelgen.analysis.modal import ModalResult, modal
from modelgen.analysis.motion_evidence import MotionEvidence, motion_evidence
from modelgen.analysis.orbits import PeriodicOrbit, periodic_orbit
from modelgen.analysis.phase_vectors import PhaseVectorResult, phase_vectors
from modelgen.analysis.sections import SectionResult, poincare
from modelgen.analysis.sensitivity import SensitivityResult, sensitivities
from modelgen.analysis.sweep import sweep
from modelgen.analysis.sweep_result import SweepResult
from modelgen.analysis.window import Window, settled_window

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
    "settled_window",
    "sweep",
]
