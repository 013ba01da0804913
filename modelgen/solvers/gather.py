"""What is kept of a run in lanes: states, channels, or only their extremes and means.

Part of ``solvers``; read by ``native_memory``. A sweep of thousands of runs needs few numbers of each.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import casadi as ca

from modelgen.errors import CaseError


@dataclass(frozen=True, eq=False)
class Gather:
    """What solvers in generated C hand on besides the ending of each run.

    ``states``: at all output times; without them a trajectory holds only the place where its run ended, and memory stays flat.
    ``channels``: a CasADi function (t, x, p) -> one dense column, evaluated at the output times within the run and reduced to the
    lowest, highest, mean and mean square value of each entry; with ``keep`` all values are handed on too. ``events``: how many
    events of each run are logged (None: all); they are counted all the same.
    Raises CaseError for another signature.

    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 1)
    >>> Gather(states=False, channels=ca.Function("energy", [t, x, p], [ca.sumsqr(x)])).keep
    False
    """

    states: bool = True
    channels: ca.Function | None = None
    keep: bool = False
    events: int | None = None

    def __post_init__(self) -> None:
        for name in ("states", "keep"):
            if not isinstance(getattr(self, name), bool):
                raise CaseError(f"gather, {name}", f"is {getattr(self, name)!r}", "give True or False")
        limit: Any = self.events
        if limit is not None and (isinstance(limit, bool) or not isinstance(limit, int) or limit < 0):
            raise CaseError("gather, events", f"is {limit!r}", "give a whole number from 0 up, or None for all")
        if self.channels is not None:
            _check_channels(self.channels)
        elif self.keep:
            raise CaseError("gather, keep", "is asked for without channels", "give a function (t, x, p) -> column")


def _check_channels(channels: Any) -> None:
    if not isinstance(channels, ca.Function):
        raise CaseError("gather, channels", f"is a {type(channels).__name__}", "give a casadi.Function (t, x, p) -> column")
    if (channels.n_in(), channels.n_out()) != (3, 1):
        found = f"has {channels.n_in()} inputs and {channels.n_out()} outputs"
        raise CaseError("gather, channels", found, "wanted are (t, x, p) -> column")
    if channels.size2_out(0) != 1 or channels.size1_out(0) < 1:
        raise CaseError("gather, channels", f"gives {channels.size_out(0)}", "wanted is a column with at least one entry")


@functools.lru_cache(maxsize=64)
def written_out(function: ca.Function) -> ca.Function:
    """A function as one dense column, written out operation by operation."""
    inputs = [ca.SX.sym(function.name_in(index), function.sparsity_in(index)) for index in range(function.n_in())]
    return ca.Function(function.name(), inputs, [ca.densify(ca.vec(function(*inputs)))])
