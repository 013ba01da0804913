"""Question: how does the answer change with the parameters? Many points of one case, on all cores or a cluster, safe from kills.

The main sentence of ``sweeps``: ``points`` and ``collect`` say what is asked; ``batch`` computes,
here, in worker processes (``crew``) or on a cluster (``cluster``); ``store`` keeps what is finished;
``SweepResult`` answers. A sweep in a folder goes on where it ended, and the table at its end is the same bytes whatever happened
on the way.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from modelgen.analysis.sweeps.batch import Runner, key_of, settled
from modelgen.analysis.sweeps.cluster import run_cluster
from modelgen.analysis.sweeps.collect import SHARE, collection_of
from modelgen.analysis.sweeps.crew import Crew, crew_options
from modelgen.analysis.sweeps.job import job_text, portable
from modelgen.analysis.sweeps.points import Points, points_of
from modelgen.analysis.sweeps.record import Record
from modelgen.analysis.sweeps.result import SweepResult
from modelgen.analysis.sweeps.shard import Batch, decode, encode
from modelgen.analysis.sweeps.store import TABLE, Store, digest_of, opened, refuse_foreign
from modelgen.analysis.sweeps.work import DEATHS, Work
from modelgen.analysis.time_domain.window import settled_window
from modelgen.errors import CaseError
from modelgen.solvers.asked_case import asked_case
from modelgen.solvers.bound_model import bind
from modelgen.solvers.case import Case
from modelgen.solvers.lanes import cores
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.simulate import events_of

FORMAT = 1
MEMORY = 4 * 2**30  # bytes that results may take
PER_POINT = 500  # bytes of a point beside its numbers

Progress = Callable[[int, int], None]


def sweep(
    case: Any,
    over: Mapping[str, Any],
    collect: Sequence[str],
    *,
    sampling: str = "grid",
    count: int | None = None,
    out: str | Path | None = None,
    fresh: bool = False,
    workers: int | None = None,
    client: Any = None,
    progress: Progress | None = None,
) -> SweepResult:
    """Runs a case at many points.

    ``over``: values by name of parameters, also those of the operating point (``speed``, loads); ``sampling`` makes points of
    them (``grid``, ``list``; ``random``, ``sobol`` with ``count`` and the case's seed), see ``points_of``. ``collect``:
    statistics such as ``coupling.torque.highest`` (.lowest, .mean, .rms, .amplitude, .final) over the case's output times,
    whole channels (``coupling.torque``), ``steps``, ``rejected``, ``events``, shares of modes (``mesh.flank.drive.share``).
    ``out``: a folder that keeps what is finished and gets ``table.csv``; the same sweep goes on in it, unless ``fresh``.
    ``workers``: processes, by default as many as cores; 0 computes in this process, which is also done for models that are more
    than a model file can say. ``client``: a ``distributed.Client`` of a cluster. ``progress(done, points)`` is called on the way.
    The solver runs in generated C where it can, unless the case's options ask for the back end "vm". A point that fails is an
    outcome in the result, never an error. So is one with which workers die three times, alone and when all else is done; it
    stands in the table, not in the store, so the same sweep tries it again.

    Instead of a case, any model may be given: its points run from the static state, over its settled window.

    Raises NamingError, UnitError, ModelError or CaseError for what cannot be asked, for a folder of something else, and where the
    disk does not take the results.

    >>> from modelgen import Driveline, Inertia, Shaft
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> case = Case(line, end=0.2, start={"shaft.twist": 0.01}, options={"backend": "vm"})
    >>> result = sweep(case, {"shaft.stiffness": ["10 kN*m/rad", "20 kN*m/rad"]}, ["shaft.torque.highest"], workers=0)
    >>> result["shaft.torque.highest"].round(3).tolist()
    [100.0, 200.0]
    """
    case = asked_case(case, "sweep") if isinstance(case, Case) else _once_settled(case)
    wanted = collection_of(case.model, collect, case.samples)
    most = MEMORY // (8 * (len(over) + wanted.width) + PER_POINT) if isinstance(over, Mapping) else 1
    points = points_of(case.model, over, sampling, count, case.seed, most)
    _refuse_unlawful(case, points)
    processes = crew_options(workers)
    if out is not None:
        refuse_foreign(out, f"sweep folder {str(out)!r}")
    case, engine = settled(case)
    shares = [name for name in wanted.counts if name.endswith(SHARE)]
    if shares and events_of(case) is None:
        raise CaseError(f"sweep, {shares[0]!r}", "needs events to be located", 'give the case the option events "on"')
    plan = plan_of(case, engine, points, tuple(collect))
    record = Record(len(points), wanted.width)

    def compute(store: Store | None) -> None:
        if store is not None:
            for batch in store.batches():
                record.put(batch)
        _run(case, engine, points, tuple(collect), digest_of(plan), record, store, processes, client, progress)

    if out is None:
        compute(None)
        return record.result(case, engine, points, wanted)
    with opened(out, plan, fresh) as store:
        compute(store)
        result = record.result(case, engine, points, wanted, tuple(store.notes))
        store.write(TABLE, result.csv_text().encode())
    return result


def _once_settled(x: Any) -> Case:
    """A case over the settled window of a model. Raises CaseError for what is none, or has no base frequency."""
    bound = bind(x, question="sweep")
    window = settled_window(bound)
    return asked_case(bound, "sweep", end=window.last, record_from=window.first)


def _refuse_unlawful(case: Case, points: Points) -> None:
    """Raises NamingError, ModelError, UnitError or CaseError for what is wrong with all points alike."""
    own = {name: value for name, value in case.parameters.items() if name not in points.names}
    case.model.parameters.unbalanced(own)
    starts = {} if isinstance(case.start, str) else case.start
    for name in starts:
        case.model.state_index(name)
    try:
        json.dumps(case.data(), allow_nan=False)
    except ValueError:
        raise CaseError("sweep, case", "holds a number that is not finite", "give finite parameters and starts") from None


def plan_of(case: Case, engine: Mapping[str, Any], points: Points, collect: tuple[str, ...]) -> dict[str, Any]:
    """Everything that decides the table of a sweep, as plain data; two sweeps with equal plans have equal tables."""
    return {
        "format": FORMAT,
        "case": case.data(),
        "digest": key_of(case),
        "engine": dict(engine),
        "points": {
            "sampling": points.sampling,
            "seed": points.seed,
            "names": list(points.names),
            "units": list(points.units),
            "axes": [axis.tolist() for axis in points.axes],
            "values": [] if points.axes else points.values.tolist(),
        },
        "collect": list(collect),
    }


def _run(
    case: Case,
    engine: Mapping[str, Any],
    points: Points,
    collect: tuple[str, ...],
    plan: str,
    record: Record,
    store: Store | None,
    processes: int,
    client: Any,
    progress: Progress | None,
) -> None:
    """Compute what is missing in the record."""
    missing = record.missing()
    total = len(points)

    def say() -> None:
        if progress is not None:
            progress(total - record.left, total)

    def accept(raw: bytes) -> None:
        batch = decode(raw)
        if store is not None:
            store.add(raw, int(batch.points[0]))
        record.put(batch)
        say()

    say()
    if not len(missing):
        return
    width = int(engine.get("lanes", 1))
    runner = Runner(case, engine, points.names, collect, plan)

    def mark(point: int, how: str) -> None:
        message = f"not finished: the worker died {DEATHS} times on this point ({how}); the same sweep tries it again"
        at = np.array([point], dtype=np.int64)
        key = key_of(runner.at(points.values[point].tolist()))
        numbers = np.full((1, runner.wanted.width), np.nan)
        # Not kept in the store: who kills workers may be someone else than the point.
        record.put(Batch(plan, at, (key,), (Outcome.SOLVER_ERROR.name,), (message,), numbers))
        say()

    carried = portable(case)
    if client is not None:
        if not carried:
            raise CaseError(f"sweep of {case.model.name!r}", "has a model that no model file can hold", "compute it here")
        if not callable(getattr(client, "submit", None)):
            raise CaseError("sweep, client", f"is {client!r:.60}", "give a distributed.Client")
        work = Work(missing, width, cores())
        run_cluster(client, job_text(case, engine, points.names, collect, plan), points.values, work, accept, mark)
    elif processes and carried and len(missing) > width:
        count = min(processes, -(-len(missing) // width))
        work = Work(missing, width, count)
        Crew(job_text(case, engine, points.names, collect, plan), points.values, work, count, accept, mark).run()
    else:
        _run_here(runner, points, Work(missing, width * cores(), 1), accept)


def _run_here(runner: Runner, points: Points, work: Work, accept: Callable[[bytes], None]) -> None:
    """Batch after batch in this process, with lanes on all cores."""
    while (batch := work.take()) is not None:
        began = time.perf_counter()
        accept(encode(runner.run(batch, points.values[batch], threads=cores())))
        work.took(batch, time.perf_counter() - began)
