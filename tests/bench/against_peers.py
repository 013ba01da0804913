"""Error against cost beside every peer, in one run: ``make bench``. Writes out/bench: summary.json, table.md and figures.

    python tests/bench/against_peers.py [--quick] [--only PART ...] [--out DIR]

Models: the truck of the catalogue (events at the flanks), a smooth one (the truck without backlash at mean stiffness), a gear
pair; the paper's bifurcation diagram; a growing chain. Error: largest over vibrating channels (twists, approaches along the line
of action, their rates) of the difference from a tight solution, per half the peak-to-peak of the channel, from the static start.
Every peer runs as its own manual advises; all cores for all. A part that fails is named in the summary, and the others go on.
"""

from __future__ import annotations

import argparse
import logging
import time
import traceback
from collections.abc import Callable
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from curves import failure_text
from diagram import diagram
from questions import COLUMNS, END, QUESTIONS, QUICK_COLUMNS, QUICK_END
from report import machine, table, written
from scaling import scaling

PACKAGES = ("modelgen", "numpy", "scipy", "casadi", "numba", "heyoka", "jitcode", "diffrax", "jax")
PARTS: dict[str, Callable[[bool, Path], dict[str, Any]]] = {
    **{each.key: each.run for each in QUESTIONS},
    "diagram": diagram,
    "scaling": scaling,
}


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def main() -> int:
    """Runs the parts; 1 if any of them failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="short runs, to see that everything works")
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    parser.add_argument("--only", nargs="*", choices=PARTS, metavar="PART", help=", ".join(PARTS))
    options = parser.parse_args()
    quick, out = options.quick, options.out
    logging.disable(logging.DEBUG)  # a peer turns on everybody's
    out.mkdir(parents=True, exist_ok=True)
    summary: dict[str, Any] = {
        "machine": machine(), "date": date.today().isoformat(), "quick": quick, "end_s": QUICK_END if quick else END,
        "sweep": QUICK_COLUMNS if quick else COLUMNS, "versions": {name: _version(name) for name in PACKAGES},
        "curves": {}, "failures": {},
    }  # fmt: skip
    started = time.perf_counter()
    for name, part in PARTS.items():
        if options.only and name not in options.only:
            continue
        try:
            told = part(quick, out)
        except Exception as failure:
            traceback.print_exc()
            told = {}
            summary["failures"][name] = failure_text(failure)
        summary["curves"] |= told.pop("curves", {})
        summary |= told
        summary["minutes"] = (time.perf_counter() - started) / 60
        written(summary, out)  # after every part: an interrupted run leaves what is done
    print(table(summary))
    print(f"{summary['minutes']:.1f} minutes; {out}/summary.json")
    return 1 if summary["failures"] else 0


if __name__ == "__main__":
    raise SystemExit(main())
