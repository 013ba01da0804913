"""Questions: one per file, each a function from a model or a solution to a result that ``plots`` can draw."""

from modelgen.analysis.angles import AnglesResult, angles
from modelgen.analysis.campbell import CampbellResult, CriticalSpeed, OrderLine, campbell
from modelgen.analysis.forced import ForcedResult, Swings, forced
from modelgen.analysis.frequency_response import frequency_response
from modelgen.analysis.gear_hammer import GearLoad, HammerResult, gear_hammer
from modelgen.analysis.modal import ModalResult, modal
from modelgen.analysis.phase_vectors import PhaseVectorResult, phase_vectors
from modelgen.analysis.sensitivity import SensitivityResult, sensitivities
from modelgen.analysis.window import Window, settled_window

__all__ = [
    "AnglesResult",
    "CampbellResult",
    "CriticalSpeed",
    "ForcedResult",
    "GearLoad",
    "HammerResult",
    "ModalResult",
    "OrderLine",
    "PhaseVectorResult",
    "SensitivityResult",
    "Swings",
    "Window",
    "angles",
    "campbell",
    "forced",
    "frequency_response",
    "gear_hammer",
    "modal",
    "phase_vectors",
    "sensitivities",
    "settled_window",
]
