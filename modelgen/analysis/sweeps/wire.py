"""Messages between a sweep and its worker processes: a kind, a length, and that many bytes.

Part of ``sweeps``; spoken by ``crew`` and ``worker``.
"""

from __future__ import annotations

import json
import struct
from typing import IO

import numpy as np

JOB, READY, POINTS, BATCH, REFUSED = b"J", b"R", b"P", b"B", b"E"
FRAME = struct.Struct("<cQ")


def send(stream: IO[bytes], kind: bytes, content: bytes) -> None:
    """One message: its kind, its length, its content."""
    stream.write(FRAME.pack(kind, len(content)) + content)
    stream.flush()


def receive(stream: IO[bytes]) -> tuple[bytes, bytes] | None:
    """The next message; None when the other side has gone, even in the middle of one."""
    head = stream.read(FRAME.size)
    if len(head) < FRAME.size:
        return None
    kind, length = FRAME.unpack(head)
    content = stream.read(length)
    return (kind, content) if len(content) == length else None


def points_text(points: np.ndarray, values: np.ndarray) -> bytes:
    """Points by number with their values, as bytes."""
    return json.dumps({"points": points.tolist(), "values": values.tolist()}).encode()
