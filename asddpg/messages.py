"""Messages on standard output and standard error, which never end the work that they are about."""

import errno
import sys
from typing import Any


class MessageStream:
    """Standard output or standard error, as `sys` has it at the moment of each message; writing raises nothing.

    What the stream cannot encode is escaped. Where there is none, or its disk is full, the message is lost.
    """

    def __init__(self, name: str) -> None:
        """`name` is stdout or stderr."""
        self._name = name
        self._broken: Any = None  # the stream that failed

    @property
    def is_broken(self) -> bool:
        """Whether its reader or its terminal is gone, as far as messages have found."""
        return self._broken is not None and self._broken is getattr(sys, self._name)

    def write(self, text: str) -> None:
        """Write a text."""
        encoding = getattr(getattr(sys, self._name), "encoding", None) or "utf-8"
        self._call("write", text.encode(encoding, "backslashreplace").decode(encoding))

    def flush(self) -> None:
        """Write out what is kept; only then a stream shows that it is broken."""
        self._call("flush")

    def isatty(self) -> bool:
        """Whether it is a terminal."""
        return bool(self._call("isatty"))

    def __getattr__(self, name: str) -> Any:
        # tqdm looks for the encoding, and by fileno for the width of the terminal.
        return getattr(getattr(sys, self._name), name)

    def _call(self, method: str, *arguments: str) -> Any:
        stream = getattr(sys, self._name)
        try:
            return getattr(stream, method)(*arguments)
        except Exception as error:  # closed, none, full, or the caller's own object
            if is_gone(error):
                self._broken = stream
            return None


def is_gone(error: Exception) -> bool:
    """Whether a stream failed because its reader, or its terminal, is gone."""
    return isinstance(error, ConnectionError) or (isinstance(error, OSError) and error.errno == errno.EIO)


OUT, ERR = MessageStream("stdout"), MessageStream("stderr")


def say(text: str, stream: MessageStream = OUT) -> None:
    """Write a line at once."""
    print(text, file=stream, flush=True)
