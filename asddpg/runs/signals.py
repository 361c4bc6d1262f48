"""Graceful stop: a signal ends a training after the step in progress."""

import signal
from types import FrameType
from typing import Self

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # Ctrl-C, a scheduler, a terminal that is closed


class Stopped(Exception):  # noqa: N818  # it is no error
    """A signal has stopped the training after a whole step."""

    def __init__(self, number: int) -> None:
        """Stopped by the signal of that number."""
        super().__init__(signal.Signals(number).name)
        self.status = 128 + number  # as shells report it


class StopSignals:
    """Records the first signal; a SIGINT after it stops at once.

    Other signals after the first are ignored: a program under `make`, or in a process group that is ended, may receive
    the same one twice.
    """

    def __init__(self) -> None:
        self.number = 0  # of the signal that came

    def raise_if_received(self) -> None:
        """Stop here, if a signal has come.

        Raises:
            Stopped: one has.
        """
        if self.number:
            raise Stopped(self.number)

    def __enter__(self) -> Self:
        # Ignored signals stay ignored, such as SIGHUP under nohup.
        before = {number: signal.getsignal(number) for number in _SIGNALS}
        self._before = {number: handler for number, handler in before.items() if handler != signal.SIG_IGN}
        for number in self._before:
            signal.signal(number, self._record)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _record(self, number: int, _: FrameType | None) -> None:
        if self.number and number == signal.SIGINT:
            raise KeyboardInterrupt
        self.number = self.number or number
