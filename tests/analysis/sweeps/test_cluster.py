"""A sweep on Dask: a local cluster, workers started by hand, one killed in the middle; always the bytes of the serial run."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modelgen import Case
from modelgen.analysis import sweep
from modelgen.analysis.sweeps.cluster import connect
from modelgen.analysis.sweeps.store import SHARDS, TABLE
from modelgen.errors import CaseError

from .cases import COLLECT, small_case

distributed = pytest.importorskip("distributed", reason="the extra dask is not installed")
pytestmark = pytest.mark.filterwarnings("default")  # those of Dask are not ours
ROOT = Path(__file__).parents[3]
OVER = {"zeta": np.linspace(0.01, 0.2, 60).tolist()}
QUIET = {"distributed.admin.log-format": "", "distributed.comm.timeouts.connect": "10s"}


@pytest.fixture(scope="module")
def case() -> Case:
    return small_case(end=0.5)


@pytest.fixture(scope="module")
def table(case: Case) -> str:
    return sweep(case, OVER, COLLECT, workers=0).csv_text()


@pytest.fixture(scope="module")
def by_hand() -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A scheduler in this process, and worker processes of Dask started by their command, as on other machines."""
    with distributed.LocalCluster(
        n_workers=0, processes=False, dashboard_address=None, host="127.0.0.1", protocol="tcp://", silence_logs=50
    ) as cluster:
        address = cluster.scheduler_address
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "default"}
        command = [
            sys.executable,
            "-m",
            "distributed.cli.dask_worker",
            address,
            "--no-dashboard",
            "--nthreads",
            "1",
            "--no-nanny",
        ]
        workers = [
            subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) for _ in range(2)
        ]
        yield address, workers
        for worker in workers:
            worker.kill()
            worker.wait()


def test_a_local_cluster(case: Case, table: str, tmp_path: Path) -> None:
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert sweep(case, OVER, COLLECT, client=client, out=tmp_path / "s").csv_text() == table
    assert (tmp_path / "s" / TABLE).read_text() == table


def test_workers_by_hand_of_which_one_is_killed(
    case: Case, table: str, tmp_path: Path, by_hand: tuple[str, list[Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("modelgen.analysis.sweeps.work.Work.size", lambda self: 2)
    address, workers = by_hand
    with connect(address) as client:
        client.wait_for_workers(2, timeout=60)

        def kill_in_the_middle() -> None:
            while len(list((tmp_path / "s" / SHARDS).glob("*.shard"))) < 5:
                time.sleep(0.005)
            workers[0].kill()

        killer = threading.Thread(target=kill_in_the_middle, daemon=True)
        killer.start()
        assert sweep(case, OVER, COLLECT, client=client, out=tmp_path / "s").csv_text() == table
        killer.join()
        assert len(client.nthreads()) == 1


def test_equations_given_directly_cannot_travel() -> None:
    import sympy

    from modelgen import lower, system

    x, k = sympy.symbols("x k")
    case = Case(lower(system({x: 1.0}, {x: -k * x}, {k: 1.0})), end=1.0, samples=11, start="zero")
    with pytest.raises(CaseError, match="has a model that no model file can hold"):
        sweep(case, {"k": [1.0, 2.0]}, ["x.final"], client=object())


@pytest.mark.parametrize("address", ["nonsense://1", "127.0.0.1"])
def test_nobody_answers(address: str) -> None:
    import dask

    # A client of Dask that found nobody stays the default scheduler until it is collected, also of tests that come after.
    with dask.config.set(scheduler=None), pytest.raises(CaseError, match="no scheduler answers"):
        connect(address)
