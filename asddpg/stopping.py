"""Stopping a training by a signal: the step is finished first."""

import signal
import sys
from collections.abc import Mapping
from types import FrameType
from typing import Self, SupportsFloat

from asddpg.types import Step, Watcher

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Stopped(Exception):  # noqa: N818  # it is no error
    """The training was asked to stop, and has finished its step."""

    def __init__(self, number: int) -> None:
        """Stopped by the signal of that number."""
        super().__init__(signal.Signals(number).name)
        self.status = 128 + number  # as a shell tells it


class StopSignals:
    """Notes the first SIGINT or SIGTERM; the second one stops at once."""

    def __init__(self) -> None:
        self.number = 0  # of the signal that came

    def __enter__(self) -> Self:
        self._before = {number: signal.signal(number, self._note) for number in _SIGNALS}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.number = number
        for each in _SIGNALS:
            signal.signal(each, self._at_once)

    @staticmethod
    def _at_once(number: int, _: FrameType | None) -> None:
        if number == signal.SIGINT:
            raise KeyboardInterrupt
        sys.exit(128 + number)


class StopBetweenSteps(Watcher):
    """Watches, and ends by an exception where a signal has come; for episodes of which nothing is kept."""

    def __init__(self, signals: StopSignals) -> None:
        self._signals = signals

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """End here, if asked to."""
        if self._signals.number:
            raise Stopped(self._signals.number)
