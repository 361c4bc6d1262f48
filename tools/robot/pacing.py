"""Simulation in real time."""

import time

LATE = 0.5  # s; a longer delay is skipped, a shorter one caught up


class RealTimeClock:
    """Counts the frames of simulation that are due, however long a picture takes."""

    def __init__(self, frame: float) -> None:
        """Start now, with frames of `frame` seconds."""
        self._frame = frame
        self._most = max(1, int(LATE / frame))
        self._next = time.monotonic()

    def wait_frames(self) -> int:
        """Wait until a frame is due; returns the number of frames due, at most LATE seconds of them."""
        time.sleep(max(0.0, self._next - time.monotonic()))
        due = 1 + max(0, int((time.monotonic() - self._next) / self._frame))
        self._next += due * self._frame
        return min(due, self._most)
