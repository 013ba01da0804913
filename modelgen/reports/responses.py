"""``responses.csv``: the main channels over the last period of the window, with units in the header.

Part of ``reports``. Angles are vibration angles, less their best straight line over the whole window, as in the report.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from modelgen.reports.response import Response
from modelgen.solvers.crosscheck import without_line

MOST_ROWS = 5001
KEPT = (".twist", ".torque", ".force", ".deflection")


def write_responses(response: Response, path: Path) -> Path:
    """Writes the channels; rows are thinned evenly where the last period has more than 5001 samples."""
    solution, window = response.solution, response.window
    t = solution.times
    columns = {"time [s]": t}
    for name, values in solution.channels.items():
        if name.endswith(".angle_deviation"):
            columns[f"{name.removesuffix('.angle_deviation')}.vibration_angle [rad]"] = without_line(t, values)
        elif name.endswith(KEPT):
            columns[f"{name} [{solution.unit(name)}]"] = values
    rows = np.flatnonzero(t >= window.last - window.period * (1 + 1e-9))
    rows = rows[:: -(-len(rows) // MOST_ROWS)]
    table = np.column_stack([values[rows] for values in columns.values()])
    # Nine digits: what the solvers agree on and a little more.
    np.savetxt(path, table, fmt="%.9g", delimiter=",", header=",".join(columns), comments="", encoding="utf-8")
    return path
