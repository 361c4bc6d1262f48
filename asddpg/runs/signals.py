"""Stopping a training by a signal: the step is finished first."""

import signal
from collections.abc import Mapping
from types import FrameType
from typing import Self, SupportsFloat

from asddpg.episodes.protocols import Callback, Step

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # Ctrl-C, a scheduler, a terminal that is closed


class Stopped(Exception):  # noqa: N818  # it is no error
    """The training was asked to stop, and has finished its step."""

    def __init__(self, number: int) -> None:
        """Stopped by the signal of that number."""
        super().__init__(signal.Signals(number).name)
        self.status = 128 + number  # as a shell tells it


class StopSignals:
    """Notes the first signal; a SIGINT after it stops at once.

    Other signals after the first are nothing new: a program under `make`, or in a process group that is ended, may be
    told twice.
    """

    def __init__(self) -> None:
        self.number = 0  # of the signal that came

    def __enter__(self) -> Self:
        # What is ignored stays so, such as SIGHUP under nohup.
        before = {number: signal.getsignal(number) for number in _SIGNALS}
        self._before = {number: handler for number, handler in before.items() if handler != signal.SIG_IGN}
        for number in self._before:
            signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _note(self, number: int, _: FrameType | None) -> None:
        if self.number and number == signal.SIGINT:
            raise KeyboardInterrupt
        self.number = self.number or number


class StopBetweenSteps(Callback):
    """Watches, and ends by an exception where a signal has come; for episodes of which nothing is kept."""

    def __init__(self, signals: StopSignals) -> None:
        self._signals = signals

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """End here, if asked to."""
        if self._signals.number:
            raise Stopped(self._signals.number)
