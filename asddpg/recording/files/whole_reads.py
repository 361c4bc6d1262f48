"""A file that gives what was asked for or says that it ends: mcap's reader takes half a message for a whole one."""

import os
from typing import IO

from mcap.exceptions import EndOfFile


class WholeReads:
    """The reading half of a file, as mcap's StreamReader uses it."""

    def __init__(self, file: IO[bytes]) -> None:
        """Read on from where the file stands; it must be able to seek."""
        self._file = file
        here = file.tell()
        self._size = file.seek(0, os.SEEK_END)
        file.seek(here)

    def read(self, length: int) -> bytes:
        """So many bytes.

        Raises:
            EndOfFile: there are fewer; a damaged length, which may be anything, is not allocated first.
        """
        if length > self._size - self._file.tell():
            raise EndOfFile("it ends too early")
        return self._file.read(length)
