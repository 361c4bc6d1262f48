"""Simulation in real time."""

import time
from collections.abc import Iterator

LATE = 0.5  # s; a longer delay is skipped, a shorter one caught up


def wait_for_frames(frame: float) -> Iterator[int]:
    """Wait until a frame of `frame` seconds is due; yields how many are, however long a picture takes.

    At most LATE seconds of them.
    """
    due_at = time.monotonic()
    while True:
        time.sleep(max(0.0, due_at - time.monotonic()))
        due = 1 + max(0, int((time.monotonic() - due_at) / frame))
        due_at += due * frame
        yield min(due, max(1, int(LATE / frame)))
