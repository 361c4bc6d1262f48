"""Atomic writes: a file is either complete or unchanged."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any


def write_whole(path: Path, content: bytes | memoryview) -> None:
    """Write a file and flush it to the disk before it takes its name.

    Raises:
        OSError: it could not be written; what was there before is as it was.
    """
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)  # it takes disk space that others need
        raise


@contextmanager
def closed_on_error(file: IO[Any]) -> Iterator[None]:
    """Close a file whose first lines cannot be written: Python would report that on stderr a second time."""
    try:
        yield
    except OSError:
        with suppress(OSError):  # closing tries to write the rest again
            file.close()
        raise
