"""Seconds over the number of inertias: lowering, building (nothing in the cache), one run beside the fastest peers and cvodes."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from curves import measure
from models import chain
from peers.product import Modelgen
from peers.registry import peer_named
from peers.workload import workload

from modelgen import assemble, lower

COUNTS, QUICK_COUNTS = (16, 50, 100, 200, 400), (16, 50)
END, SAMPLES = 0.2, 101


def scaling(quick: bool, out: Path) -> dict[str, Any]:
    """Entries of the summary, by number of inertias."""
    print("scaling", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["MODELGEN_CACHE"] = folder
        try:
            return {"scaling": _rows(QUICK_COUNTS if quick else COUNTS)}
        finally:
            del os.environ["MODELGEN_CACHE"]


def _rows(counts: tuple[int, ...]) -> dict[str, Any]:
    told = {}
    for count in counts:
        line = chain(count)
        start = time.perf_counter()
        model = lower(assemble(line))
        lowered = time.perf_counter() - start
        work = workload(line, END, SAMPLES, model)
        scale = np.concatenate([np.full(count, 1e-3), np.full(count, 1.0)])
        loop = peer_named("numba, Dormand-Prince loop").make([work], scale)
        exact = [work.channels(loop.single(1e-12))]
        start = time.perf_counter()
        ours = [Modelgen(model, [{}], END, SAMPLES, "rk4", "off")]
        built = time.perf_counter() - start
        ours += [Modelgen(model, [{}], END, SAMPLES, "dop853", "off")]
        row = {"lower_s": lowered, "build_s": built}
        peers = [peer_named(name).make([work], scale) for name in ("heyoka, without events", "CasADi cvodes, virtual machine")]
        for peer in (*ours, loop, *peers):
            row[peer.name] = measure(peer, [work], exact, False, 1).seconds_at(1e-5, "median")
        told[str(count)] = row
    return told
