"""Worker processes of a sweep on this machine, one per core, and their supervision.

Part of ``sweeps``. Processes and not threads, because a process that is killed, or that a fault in compiled code takes down,
takes nothing else with it, and because preparing a point is Python, which threads would do one after the other. They are started
by their command and spoken to in plain messages: nothing is pickled, the caller's main module is not run again, and a terminal's
Ctrl-C reaches this process only. The results come here, and only this process writes. A worker that ends for whatever reason, or
that somebody stops (SIGSTOP) and forgets, is replaced, and what it had is done again.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.sweeps.shard import DamagedError, decode
from modelgen.analysis.sweeps.wire import BATCH, JOB, POINTS, READY, REFUSED, points_text, receive, send
from modelgen.analysis.sweeps.work import Work
from modelgen.errors import CaseError
from modelgen.solvers.lanes import cores

Array = NDArray[np.float64]
Accept = Callable[[bytes], None]
Mark = Callable[[int, str], None]
STILLBORN = 20  # workers in a row that end before they are ready
PATIENCE = 0.5  # s between two looks for something to do besides waiting
STOPPED = 5.0  # s that a worker may be held by a signal
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Matrices are small here, and every core has its worker."""


class _Worker:
    """A worker process: what it is at, and a thread that listens to it."""

    def __init__(self, job: bytes, answers: queue.SimpleQueue[tuple[_Worker, bytes, bytes]]) -> None:
        self.batch: NDArray[np.int64] | None = None
        self.began = 0.0
        self.ready = False
        self.stopped: float | None = None
        self.words = tempfile.TemporaryFile()  # noqa: SIM115 - closed when the worker has ended
        root = str(Path(__file__).parents[3])
        path = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
        self.process = subprocess.Popen(
            [sys.executable, "-m", "modelgen.analysis.sweeps.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.words,
            env={**os.environ, **ONE_THREAD, "PYTHONPATH": path},
            start_new_session=True,  # so that Ctrl-C does not reach it
        )
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.orders: IO[bytes] = self.process.stdin
        threading.Thread(target=self._listen, args=(self.process.stdout, answers), daemon=True).start()
        self._order(JOB, job)

    def _listen(self, stream: IO[bytes], answers: queue.SimpleQueue[tuple[_Worker, bytes, bytes]]) -> None:
        with contextlib.suppress(OSError, ValueError), stream:
            while (answer := receive(stream)) is not None:
                answers.put((self, *answer))
        answers.put((self, b"", b""))

    def _order(self, kind: bytes, content: bytes) -> None:
        with contextlib.suppress(OSError):  # it has ended; the listener says so
            send(self.orders, kind, content)

    def give(self, batch: NDArray[np.int64], values: Array) -> None:
        """Have a batch computed."""
        self.batch, self.began = batch, time.perf_counter()
        self._order(POINTS, points_text(batch, values[batch]))

    def held(self) -> bool:
        """Whether a signal has held it for too long, where the system can tell."""
        if not hasattr(os, "waitid"):
            return False
        now = time.monotonic()
        try:
            held = os.waitid(os.P_PID, self.process.pid, os.WSTOPPED | os.WNOHANG | os.WNOWAIT) is not None
        except ChildProcessError:  # it has ended
            held = False
        self.stopped = (self.stopped or now) if held else None
        return self.stopped is not None and now - self.stopped > STOPPED

    def end(self) -> None:
        """End it, whatever it does."""
        self.process.kill()
        with contextlib.suppress(OSError):
            self.orders.close()
        self.process.wait()
        self.words.close()

    def last_words(self) -> str:
        """The last line that it wrote, or how it ended."""
        self.words.seek(0)
        lines = self.words.read().decode(errors="replace").strip().splitlines()
        code = self.process.wait()
        return lines[-1] if lines else f"ended by signal {-code}" if code < 0 else f"ended with code {code}"


class Crew:
    """Workers, and what they are told; ``accept`` takes each encoded batch, ``mark`` a point that no worker survives."""

    def __init__(self, job: str, values: Array, work: Work, count: int, accept: Accept, mark: Mark) -> None:
        self.job, self.values, self.work, self.count = job.encode(), values, work, count
        self.accept, self.mark = accept, mark
        # SimpleQueue, because Ctrl-C in the middle of a wait leaves it whole.
        self.answers: queue.SimpleQueue[tuple[_Worker, bytes, bytes]] = queue.SimpleQueue()
        self.workers: list[_Worker] = []
        self.stillborn = 0

    def run(self) -> None:
        """Work until nothing is left. Raises CaseError where workers cannot start, and what ``accept`` raises."""
        try:
            while self.work or any(each.batch is not None for each in self.workers):
                while self.work and len(self.workers) < self.count:
                    self.workers.append(_Worker(self.job, self.answers))
                for each in self.workers:
                    if each.held():
                        each.process.kill()
                try:
                    worker, kind, content = self.answers.get(timeout=PATIENCE)  # with a limit, so that Ctrl-C is heard
                except queue.Empty:
                    continue
                self._heard(worker, kind, content)
        except OSError as error:
            raise CaseError("sweep", f"workers cannot be started: {error.strerror}", "take fewer workers") from None
        finally:
            for each in self.workers:
                each.end()

    def _heard(self, worker: _Worker, kind: bytes, content: bytes) -> None:
        if kind == READY:
            worker.ready, self.stillborn = True, 0
        elif kind == BATCH:
            if not self._took(worker, content):
                return
        elif kind == REFUSED:
            raise CaseError(*json.loads(content))
        else:
            self._ended(worker)
            return
        batch = self.work.take()
        if batch is not None:
            worker.give(batch, self.values)
        else:
            self._rest()

    def _took(self, worker: _Worker, content: bytes) -> bool:
        """Hand a batch on; a worker that sends anything else is ended."""
        try:
            points = decode(content).points
        except DamagedError:
            points = None
        if points is None or worker.batch is None or not np.array_equal(points, worker.batch):
            worker.process.kill()
            return False
        self.accept(content)
        self.work.took(points, time.perf_counter() - worker.began)
        worker.batch = None
        return True

    def _ended(self, worker: _Worker) -> None:
        """A worker has ended by itself, or somebody killed it."""
        self.workers.remove(worker)
        how = worker.last_words()
        worker.end()
        if worker.batch is not None:
            if worker.stopped is not None:
                self.work.returned(worker.batch)
            elif (point := self.work.died(worker.batch)) is not None:
                self.mark(point, how)
            self._rest()
            return
        self.work.disturbed()
        if not worker.ready:
            self.stillborn += 1
            if self.stillborn >= STILLBORN:
                raise CaseError("sweep", f"workers end before they are ready: {how}", "look into it, or take no workers (0)")

    def _rest(self) -> None:
        """What came back is for those who wait."""
        for each in self.workers:
            if each.ready and each.batch is None:
                batch = self.work.take()
                if batch is None:
                    return
                each.give(batch, self.values)


def crew_options(workers: Any) -> int:
    """The number of workers. Raises CaseError for anything but a whole number."""
    if workers is None:
        return cores()
    if isinstance(workers, bool) or not isinstance(workers, int) or not 0 <= workers <= 4096:
        raise CaseError("sweep, workers", f"is {workers!r}", "give a whole number; 0 computes in this process")
    return workers
