"""Rich displays for notebooks: equations as mathematics, drivelines and figures as pictures. Installed here and nowhere above.

``import modelgen.notebook`` in a notebook is enough; outside of one it does nothing.
"""

from __future__ import annotations

import io
from typing import Any

from modelgen.equations import Equations
from modelgen.model import Driveline


def figure_png(figure: Any) -> bytes:
    """PNG bytes of a Matplotlib figure, at the size of a notebook column."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=110, metadata={"Software": None})
    return stream.getvalue()


def driveline_png(line: Driveline) -> bytes:
    """The driveline drawn, as PNG bytes."""
    from modelgen.plots import draw

    return figure_png(draw(line))


def equations_markdown(equations: Equations) -> str:
    """The equations as Markdown with LaTeX."""
    return equations.markdown()


def install(shell: Any = None) -> bool:
    """Registers the displays with a running IPython; returns whether there is one."""
    if shell is None:
        try:
            from IPython import get_ipython
        except ImportError:
            return False
        shell = get_ipython()
    if shell is None:
        return False
    png = shell.display_formatter.formatters["image/png"]
    png.for_type(Driveline, driveline_png)
    png.for_type_by_name("matplotlib.figure", "Figure", figure_png)
    shell.display_formatter.formatters["text/markdown"].for_type(Equations, equations_markdown)
    return True


install()
