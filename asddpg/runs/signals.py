"""Graceful stop: a signal ends a training after the step in progress."""

import signal
from contextlib import suppress
from types import FrameType
from typing import Any, Self

from asddpg.messages import ERR, OUT

_HANGUP: signal.Signals = getattr(signal, "SIGHUP", signal.SIGTERM)  # Windows has no SIGHUP
_SIGNALS = {signal.SIGINT, signal.SIGTERM, _HANGUP}  # Ctrl-C, a scheduler, a terminal that is closed


class Stopped(Exception):  # noqa: N818  # it is no error
    """A signal has stopped the training after a whole step."""

    def __init__(self, number: int) -> None:
        """Stopped by the signal of that number."""
        super().__init__(signal.Signals(number).name)
        self.status = 128 + number  # as shells report it


class StopSignals:
    """Records the first signal; a SIGINT after it stops at once. In a thread, where none arrives, nothing is set up.

    Other signals after the first are ignored: a program under `make`, or in a process group that is ended, may receive
    the same one twice.
    """

    def __init__(self) -> None:
        self._number = 0

    @property
    def number(self) -> int:
        """The first signal, 0 where none came. A broken standard stream counts as SIGHUP, as a closed terminal is."""
        if not self._number and (OUT.is_broken or ERR.is_broken) and signal.getsignal(_HANGUP) != signal.SIG_IGN:
            self._number = _HANGUP
        return self._number

    def raise_if_received(self) -> None:
        """Stop here, if a signal has come.

        Raises:
            Stopped: one has.
        """
        if number := self.number:
            raise Stopped(number)

    def __enter__(self) -> Self:
        self._before: dict[int, Any] = {}
        with suppress(ValueError):  # in a thread
            for number in _SIGNALS:
                # Ignored signals stay ignored, such as SIGHUP under nohup; None is a handler that is not Python's.
                if (before := signal.getsignal(number)) not in (signal.SIG_IGN, None):
                    signal.signal(number, self._record)
                    self._before[number] = before
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _record(self, number: int, _: FrameType | None) -> None:
        if self._number and number == signal.SIGINT:
            raise KeyboardInterrupt
        self._number = self._number or number
