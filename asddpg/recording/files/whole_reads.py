"""A file that returns all requested bytes or raises: mcap's reader accepts a message that is cut off."""

import os
from typing import IO

from mcap.exceptions import EndOfFile


class WholeReads:
    """The reading half of a file, as mcap's StreamReader uses it."""

    def __init__(self, file: IO[bytes]) -> None:
        """Read on from the present position of a seekable file."""
        self._file = file
        here = file.tell()
        self._size = file.seek(0, os.SEEK_END)
        file.seek(here)

    def read(self, length: int) -> bytes:
        """Read `length` bytes.

        Raises:
            EndOfFile: there are fewer; so a damaged length allocates no memory.
        """
        if length > self._size - self._file.tell():
            raise EndOfFile("it ends too early")
        return self._file.read(length)
