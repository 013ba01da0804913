"""Which peers there are, as data: a class of this package and its options. Each is imported and built when its turn comes."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np

from .workload import Workload


@dataclass(frozen=True)
class Peer:
    """``slow``: gets an eighth of a sweep; ``slowest``: asked about the truck only, a sixteenth of its sweep."""

    name: str
    module: str
    kind: str
    options: dict[str, Any] = field(default_factory=dict)
    slow: bool = False
    slowest: bool = False

    def fits(self, work: Workload) -> bool:
        """Events at the flanks need flanks with a gap."""
        return self.name != "heyoka, events" or bool((work.meshes[:, 4] > 0).any())

    def make(self, works: list[Workload], scale: np.ndarray) -> Any:
        """The peer, ready to run. Raises what its package raises, ImportError where it is not installed."""
        return getattr(import_module(f"{__package__}.{self.module}"), self.kind)(works, scale, **self.options)


PEERS = (
    Peer("numba, Dormand-Prince loop", "numba_peer", "Numba"),
    Peer("heyoka, events", "heyoka_peer", "Heyoka"),
    Peer("heyoka, without events", "heyoka_peer", "Heyoka", {"with_events": False}),
    Peer("CasADi erk, generated C", "casadi_peer", "CasADi", {"plugin": "erk", "generated": True}),
    Peer("JiTCODE, dopri5", "jitcode_peer", "JiTCODE"),
    Peer("CasADi erk, virtual machine", "casadi_peer", "CasADi", {"plugin": "erk"}, slow=True),
    Peer("CasADi cvodes, virtual machine", "casadi_peer", "CasADi", {"plugin": "cvodes"}, slow=True),
    Peer("CasADi cvodes, compiled functions", "casadi_peer", "CasADi", {"plugin": "cvodes", "generated": True}, slow=True),
    Peer("SciPy DOP853, numba right-hand side", "scipy_peer", "SciPy", {"method": "DOP853", "compiled": True}, slow=True),
    Peer("SciPy LSODA, numba right-hand side", "scipy_peer", "SciPy", {"method": "LSODA", "compiled": True}, slow=True),
    Peer("diffrax, Dopri5", "diffrax_peer", "Diffrax", slow=True),
    Peer(
        "SciPy DOP853, Python-called right-hand side", "scipy_peer", "SciPy", {"method": "DOP853", "compiled": False},
        slow=True, slowest=True,
    ),
    Peer(
        "SciPy LSODA, Python-called right-hand side", "scipy_peer", "SciPy", {"method": "LSODA", "compiled": False},
        slow=True, slowest=True,
    ),
)  # fmt: skip


def peer_named(name: str) -> Peer:
    """One of them by its name."""
    return next(peer for peer in PEERS if peer.name == name)
