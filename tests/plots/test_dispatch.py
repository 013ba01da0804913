from __future__ import annotations

import subprocess
import sys
from typing import Any

import pytest

from modelgen.errors import CaseError
from modelgen.plots import draw, plot


def test_unknown_type_is_refused_with_what_can_be_drawn() -> None:
    words = r"no figure of a dict; give AnglesResult, .*CrosscheckResult, .*ModalResult.*draw\(\) takes a Driveline"
    with pytest.raises(CaseError, match=words):
        plot({"flywheel": 0.5})


def test_driveline_is_drawn_not_plotted(results: Any) -> None:
    with pytest.raises(CaseError, match=r"no figure of a Driveline.*draw\(\)"):
        plot(results.driveline)
    with pytest.raises(CaseError, match="no drawing of a AnglesResult; give a Driveline or its Equations"):
        draw(results.angles)


def test_neither_pyplot_nor_a_display_is_asked_for() -> None:
    code = "import sys, modelgen.plots; print('matplotlib.pyplot' in sys.modules, 'tkinter' in sys.modules)"
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == ["False", "False"]
