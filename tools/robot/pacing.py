"""Simulated time kept in step with the clock on the wall."""

import time

LATE = 0.5  # s behind the clock from which on time is let go rather than caught up


class Pace:
    """Says how many frames of simulation the clock asks for, however long a picture takes."""

    def __init__(self, frame: float) -> None:
        """Begin now, with frames of `frame` seconds."""
        self._frame = frame
        self._most = max(1, int(LATE / frame))
        self._next = time.monotonic()

    def wait(self) -> int:
        """Wait until a frame is due; gives how many are by now, at most LATE seconds of them."""
        time.sleep(max(0.0, self._next - time.monotonic()))
        due = 1 + max(0, int((time.monotonic() - self._next) / self._frame))
        self._next += due * self._frame
        return min(due, self._most)
