"""The one style of all figures: A4 reports, 16 cm wide, legible when printed in gray, safe for color-blind readers.

First file of ``plots``. Everything a figure shows is decided here or by the data: nobody's own matplotlib settings come in.
Figures are made with Matplotlib's object-oriented interface, without pyplot, a display or a global current figure. Its settings
are global all the same, so one figure is made at a time (``styled``), in whatever thread.
Colors: M. Okabe, K. Ito, Color Universal Design (2008).
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import ParamSpec

from matplotlib import style as styles
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.textpath import text_to_path

WIDTH = 16.0  # cm, between the margins of an A4 page
DPI = 200
CM = 1 / 2.54
POINT = 2.54 / 72  # cm

BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9"
INK, GRAY, PALE, FAINT = "#1A1A1A", "#5C5C5C", "#B8B8B8", "#EDEDED"
SERIES = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, INK)
DASHES = ("-", "--", "-.", ":")
TEXT, SMALL, TITLE = 8.0, 7.0, 9.5  # pt

SETTINGS = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # comes with Matplotlib: the same letters on every machine
    "mathtext.fontset": "dejavusans",
    "font.size": TEXT,
    "text.color": INK,
    "axes.titlesize": TEXT,
    "axes.titlelocation": "left",
    "axes.titlepad": 4.0,
    "axes.labelsize": TEXT,
    "axes.labelcolor": INK,
    "axes.edgecolor": GRAY,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.limits": (-4, 6),
    "axes.formatter.useoffset": False,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.5,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "xtick.color": GRAY,
    "ytick.color": GRAY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "lines.linewidth": 1.1,
    "lines.markersize": 3.5,
    "legend.fontsize": SMALL,
    "legend.frameon": False,
    "legend.handlelength": 2.2,
    "legend.borderaxespad": 0.2,
    "hatch.linewidth": 0.5,
    "figure.dpi": DPI,
    "savefig.dpi": DPI,
    "figure.facecolor": "white",
    "pdf.fonttype": 42,  # letters stay letters
    "svg.fonttype": "path",
    "svg.hashsalt": "modelgen",  # otherwise random
    "agg.path.chunksize": 20_000,  # long time series
}

_ONE_AT_A_TIME = threading.RLock()
P = ParamSpec("P")


@contextmanager
def style() -> Iterator[None]:
    """Matplotlib's defaults and then ours, for one thread at a time, and back to what was set before."""
    with _ONE_AT_A_TIME, styles.context(["default", SETTINGS]):
        yield


def styled(make: Callable[P, Figure]) -> Callable[P, Figure]:
    """A function that makes a figure, in the style, with its layout settled when it returns.

    Ticks and positions come into being when a figure is first drawn; drawn here, they are the same wherever it is shown later.
    """

    @functools.wraps(make)
    def made(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with style():
            figure = make(*args, **kwargs)
            figure.draw_without_rendering()
            figure.set_layout_engine("none")
        return figure

    return made


@functools.lru_cache(maxsize=4096)
def width_of(text: str, size: float) -> float:
    """Width [cm] of one line of plain text."""
    font = FontProperties(family="DejaVu Sans", size=size)
    return float(text_to_path.get_text_width_height_descent(text, font, ismath=False)[0]) * POINT


def filled(text: str, size: float, width: float) -> list[str]:
    """A text in lines that fill a width [cm]."""
    lines: list[str] = []
    for part in text.splitlines():
        lines.append("")
        for word in part.split():
            longer = f"{lines[-1]} {word}".strip()
            if lines[-1] and width_of(longer, size) > width:
                lines.append(word)
            else:
                lines[-1] = longer
    return lines


def sheet(model: str, what: str, detail: str = "", *, height: float, width: float = WIDTH) -> Figure:
    """An empty figure of a size in cm, headed by what it shows, of which model, and under which definitions.

    The heading is also the figure's label, from which a report takes its caption.
    """
    lines = filled(detail, SMALL, width - 0.4)
    band = 0.62 + 0.34 * len(lines)
    figure = Figure(figsize=(width * CM, (height + band) * CM), dpi=DPI)
    figure.set_layout_engine("constrained", rect=(0.005, 0.0, 0.985, height / (height + band)), w_pad=0.05, h_pad=0.05)
    inside, top = 0.2 / width, 1 - 0.12 / (height + band)
    figure.text(inside, top, f"{model}: {what}", fontsize=TITLE, fontweight="bold", va="top")
    if lines:
        below = 1 - 0.58 / (height + band)
        figure.text(inside, below, "\n".join(lines), fontsize=SMALL, color=GRAY, va="top", linespacing=1.25)
    figure.set_label(f"{model}: {what}")
    return figure


def panels(figure: Figure, rows: int, columns: int = 1, *, share_x: bool = True, share_y: bool = False) -> list[list[Axes]]:
    """Axes in rows and columns of one figure."""
    grid = figure.subplots(rows, columns, sharex=share_x, sharey=share_y, squeeze=False)
    return [list(row) for row in grid]


def page(figure: Figure) -> Axes:
    """One bare area that fills a sheet below its heading, for drawing in cm from its middle."""
    engine = figure.get_layout_engine()
    assert isinstance(engine, ConstrainedLayoutEngine)
    _, _, across, up = engine.get()["rect"]
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.0, 0.0, across, up))
    axes.set_axis_off()
    return axes


def name_panel(axes: Axes, text: str, note: str = "") -> None:
    """The small title of one panel, with a note in gray below it."""
    axes.set_title(text, fontsize=TEXT, fontweight="bold", color=INK, pad=13 if note else 4)
    if note:
        axes.annotate(
            note, (0, 1), xycoords="axes fraction", xytext=(0, 3), textcoords="offset points", fontsize=SMALL, color=GRAY
        )  # fmt: skip


def mark_value(axes: Axes, value: float, text: str, color: str = VERMILION) -> None:
    """A short text at a value of the vertical axis, outside the right end, where no data can be."""
    axes.annotate(
        text, (1, value), xycoords=("axes fraction", "data"), xytext=(2, 0), textcoords="offset points", va="center", ha="left",
        fontsize=SMALL, color=color, annotation_clip=False,
    )  # fmt: skip
