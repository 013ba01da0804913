"""A batch of finished points as bytes: the one form on the wire, on disk and between machines.

Part of ``sweeps``. A mark, the length of a head, the head (JSON: plan, points, keys, outcomes, messages), the numbers (float64,
little-endian), and the SHA-256 of all that. A batch is valid as a whole or not at all, so a torn write and a flipped bit are the
same thing: a batch that is computed again.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError

MARK = b"modelgen sweep 1\n"
LENGTH = 8
DIGEST = hashlib.sha256().digest_size


@dataclass(frozen=True, eq=False)
class Batch:
    """``points`` (m,) by number, each with its ``keys`` (digest of its Case), outcome (its name) and message, and ``numbers``
    (m, width), NaN where a point failed. ``plan``: digest of the sweep that it belongs to.
    """

    plan: str
    points: NDArray[np.int64]
    keys: tuple[str, ...]
    outcomes: tuple[str, ...]
    messages: tuple[str, ...]
    numbers: NDArray[np.float64]


class DamagedError(CaseError):
    """Bytes that are not what was written."""


def encode(batch: Batch) -> bytes:
    """The batch as bytes; equal batches give equal bytes."""
    head = json.dumps(
        {
            "plan": batch.plan,
            "points": batch.points.tolist(),
            "width": batch.numbers.shape[1],
            "keys": batch.keys,
            "outcomes": batch.outcomes,
            "messages": batch.messages,
        }
    ).encode()
    body = MARK + len(head).to_bytes(LENGTH, "little") + head + np.ascontiguousarray(batch.numbers, dtype="<f8").tobytes()
    return body + hashlib.sha256(body).digest()


def decode(raw: bytes) -> Batch:
    """The batch in bytes that ``encode`` made. Raises DamagedError for any others.

    >>> whole = encode(Batch("plan", np.arange(1), ("key",), ("SUCCESS",), ("",), np.ones((1, 2))))
    >>> decode(whole).numbers.tolist()
    [[1.0, 1.0]]
    >>> decode(whole[:-1])
    Traceback (most recent call last):
    ...
    modelgen.analysis.sweeps.shard.DamagedError: shard: is damaged; it is computed again
    """
    first = len(MARK) + LENGTH
    if len(raw) < first + DIGEST or hashlib.sha256(raw[:-DIGEST]).digest() != raw[-DIGEST:] or not raw.startswith(MARK):
        raise DamagedError("shard", "is damaged", "it is computed again")
    last = first + int.from_bytes(raw[len(MARK) : first], "little")
    try:
        head = json.loads(raw[first:last])
        points = np.array(head["points"], dtype=np.int64)
        numbers = np.frombuffer(raw[last:-DIGEST], dtype="<f8").reshape(len(points), head["width"])
        texts = [tuple(head[name]) for name in ("keys", "outcomes", "messages")]
        if any(len(each) != len(points) for each in texts):
            raise ValueError
        return Batch(head["plan"], points, texts[0], texts[1], texts[2], numbers)
    except (ValueError, KeyError, TypeError):
        raise DamagedError("shard", "was written by something else", "it is computed again") from None
