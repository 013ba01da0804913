"""A sweep on a cluster, through Dask: one task per batch of points, results back to this process, which alone writes.

Part of ``sweeps``; needs the extra ``dask``. Workers need modelgen of the same version and no shared disk: a task is the job's
text and its points, its result an encoded batch. Dask gives a task whose worker died to another one; where it gives up, the batch
is tried in pieces, as on this machine. All workers should have processors of one kind: compiled code differs by rounding from
one kind to another.
"""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.sweeps.crew import Accept, Mark
from modelgen.analysis.sweeps.job import runner_of
from modelgen.analysis.sweeps.shard import encode
from modelgen.analysis.sweeps.work import Work
from modelgen.errors import CaseError, ModelgenError

Array = NDArray[np.float64]
AHEAD = 2  # tasks per thread of the cluster, so that none waits
PATIENCE = 1.0  # s between two looks for workers
_ONE_TASK = threading.Lock()
LONELY = 120.0  # s without any worker, after which nobody is expected any more


def run_remotely(job: str, points: NDArray[np.int64], values: Array) -> tuple[bytes, float]:
    """One task: the encoded batch of these points, and the seconds it took. A worker's threads share its lanes, not its tasks."""
    from distributed import get_worker

    with _ONE_TASK:
        runner = runner_of(job)
        began = time.perf_counter()
        return encode(runner.run(points, values, threads=get_worker().state.nthreads)), time.perf_counter() - began


def connect(address: str) -> Any:
    """A client of the cluster whose scheduler has this address. Raises CaseError without Dask, or without an answer."""
    try:
        from distributed import Client
    except ImportError:
        raise CaseError("sweep on a cluster", "needs Dask, which is not installed", 'pip install "modelgen[dask]"') from None
    try:
        return Client(address, timeout=10)
    except (OSError, ValueError, TypeError) as error:
        problem = f"no scheduler answers ({type(error).__name__})"
        raise CaseError(f"cluster {address!r}", problem, "start one with dask scheduler, and give its address") from None


def run_cluster(client: Any, job: str, values: Array, work: Work, accept: Accept, mark: Mark) -> None:
    """Work until nothing is left. Raises CaseError where the cluster is lost, and what ``accept`` raises."""
    finished: queue.Queue[Any] = queue.Queue()
    running: dict[Any, NDArray[np.int64]] = {}
    seen = time.monotonic()
    try:
        while work or running:
            threads = _threads(client)
            work.workers = max(threads, 1)
            while work and len(running) < AHEAD * max(threads, 1):
                batch = work.take()
                if batch is None:
                    break
                future = client.submit(run_remotely, job, batch, values[batch], pure=False)
                running[future] = batch
                future.add_done_callback(finished.put)
            try:
                future = finished.get(timeout=PATIENCE)
            except queue.Empty:
                seen = time.monotonic() if threads else seen
                if time.monotonic() - seen > LONELY:
                    raise CaseError("cluster", f"has had no worker for {LONELY:g} s", "start some, and run this again") from None
                continue
            seen = time.monotonic()
            _finish(future, running.pop(future), work, accept, mark)
    except OSError as error:
        raise CaseError("cluster", f"is lost ({type(error).__name__})", "what is finished is kept: run this again") from None
    finally:
        with contextlib.suppress(Exception):  # the cluster may be gone, and then there is nothing to cancel
            client.cancel(list(running))


def _finish(future: Any, batch: NDArray[np.int64], work: Work, accept: Accept, mark: Mark) -> None:
    """What a task brought: a batch, the death of its workers, or a refusal."""
    from distributed.scheduler import KilledWorker

    if future.status == "finished":
        raw, seconds = future.result()
        accept(raw)
        work.took(batch, seconds)
        return
    error = future.exception() if future.status == "error" else None
    if isinstance(error, ModelgenError):
        raise error
    if error is None or isinstance(error, KilledWorker):  # lost, or given up by the scheduler
        point = work.died(batch)
        if point is not None:
            mark(point, "its workers on the cluster died")
        return
    problem = f"a worker cannot compute ({type(error).__name__}: {error!s:.200})"
    raise CaseError("cluster", problem, "give all workers modelgen of this version")


def _threads(client: Any) -> int:
    return int(sum(client.nthreads().values()))
