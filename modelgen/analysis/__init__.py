"""Questions: one per file, each a function from a model or a solution to a result that ``plots`` can draw."""

from modelgen.analysis.angles import AnglesResult, angles
from modelgen.analysis.modal import ModalResult, modal
from modelgen.analysis.window import Window, settled_window

__all__ = ["AnglesResult", "ModalResult", "Window", "angles", "modal", "settled_window"]
