"""One owner: a run's folder is written by one process at a time."""

import os
import socket
from pathlib import Path
from typing import Self

from asddpg.atomic_write import take_lock
from asddpg.errors import UserError

NAME = "lock"


class RunLock:
    """Held until the end of a `with`, or of the process: the lock is the kernel's, the file only names it.

    So a dead process holds no lock, whatever the file says.
    """

    def __init__(self, run: Path) -> None:
        """Take the lock of a run's folder.

        Raises:
            UserError: another process has it.
            OSError: the folder cannot be written.
        """
        self._path = run / NAME
        self._file = self._path.open("a+", encoding="utf-8")
        try:
            take_lock(self._file)
        except BlockingIOError as error:
            self._file.seek(0)
            owner = self._file.read().strip() or "another process"
            self._file.close()
            raise UserError(f"{run} is being written by {owner}; one process at a time may do so") from error
        self._file.truncate(0)
        self._file.write(f"process {os.getpid()} on {socket.gethostname()}\n")
        self._file.flush()

    def check(self) -> None:
        """Check that the lock is still ours.

        Raises:
            UserError: its file is gone or another one, so that another process may write the run too.
        """
        try:
            is_ours = os.path.samestat(os.fstat(self._file.fileno()), self._path.stat())
        except FileNotFoundError:
            is_ours = False
        if not is_ours:
            raise UserError(f"{self._path} has been removed or replaced: another process may write the run; stopping")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Release the lock. The file stays: removing it would let two processes hold a lock each."""
        self._file.close()
