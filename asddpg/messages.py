"""Messages on standard output and standard error, which never end the work that they are about."""

import errno
import sys
from typing import Any


class MessageStream:
    """sys.stdout or sys.stderr, as it is at the moment; nothing is raised where it is missing, closed, full or gone."""

    def __init__(self, name: str) -> None:
        """`name` is stdout or stderr."""
        self._name, self._broken = name, object()

    @property
    def is_broken(self) -> bool:
        """Whether its reader or its terminal is gone, as far as messages have found."""
        return self._broken is getattr(sys, self._name)

    def write(self, text: str) -> None:
        """Write a text at once: only then a stream shows that it is broken. What it cannot encode is escaped."""
        stream = getattr(sys, self._name)
        encoding = getattr(stream, "encoding", None) or "utf-8"
        try:
            stream.write(text.encode(encoding, "backslashreplace").decode(encoding))
            stream.flush()
        except Exception as error:  # of any kind, where the stream is an object of the caller's
            self._broken = stream if is_gone(error) else self._broken

    def flush(self) -> None:
        """Nothing is kept back."""

    def __getattr__(self, name: str) -> Any:
        return getattr(getattr(sys, self._name), name)  # tqdm reads encoding and fileno


def is_gone(error: Exception) -> bool:
    """Whether a stream failed because its reader, or its terminal, is gone."""
    return isinstance(error, ConnectionError) or getattr(error, "errno", 0) == errno.EIO


OUT, ERR = MessageStream("stdout"), MessageStream("stderr")


def print_line(text: str, stream: MessageStream = OUT) -> None:
    """Write a line."""
    stream.write(f"{text}\n")
