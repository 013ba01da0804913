"""A worker process of a sweep: ``python -m modelgen.analysis.sweeps.worker``, spoken to through its input and output.

Part of ``sweeps``, started by ``crew``. It reads a job, then batches of points, and answers each with an encoded batch. It
ends with whoever started it, at once, because its input ends then; it writes no file.
"""

from __future__ import annotations

import json
import os
import queue
import sys
import threading

import numpy as np

from modelgen.analysis.sweeps.wire import BATCH, READY, REFUSED, receive, send


def work() -> None:
    """Answer until the input ends."""
    source = sys.stdin.buffer
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever prints must not disturb the answers
    orders: queue.Queue[tuple[bytes, bytes]] = queue.Queue()

    def listen() -> None:
        while (order := receive(source)) is not None:
            orders.put(order)
        os._exit(0)  # nobody waits for what is being computed

    threading.Thread(target=listen, daemon=True).start()
    from modelgen.analysis.sweeps.job import runner_of
    from modelgen.analysis.sweeps.shard import encode
    from modelgen.errors import ModelgenError

    try:
        runner = runner_of(orders.get()[1].decode())
    except ModelgenError as error:
        send(answers, REFUSED, json.dumps([error.where, error.problem, error.remedy]).encode())
        return
    runner.warm_up()
    send(answers, READY, b"")
    while True:
        data = json.loads(orders.get()[1])
        batch = runner.run(np.array(data["points"], dtype=np.int64), np.array(data["values"]))
        send(answers, BATCH, encode(batch))


if __name__ == "__main__":
    work()
