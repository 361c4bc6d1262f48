"""Atomic writes: a file is either complete or unchanged, and two processes do not disturb each other."""

import itertools
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

try:
    import fcntl
except ModuleNotFoundError:  # Windows
    fcntl = None  # type: ignore[assignment]


def write_whole(
    path: Path,
    content: bytes | memoryview,
    on_existing: Callable[[Path], object] = lambda _: None,
    suffix: str = ".part",
) -> None:
    """Write a file and flush it to the disk before it takes its name; until then it has this suffix too.

    `on_existing` is called with a file that is there already, right before it is replaced; no other process writes the
    file between.

    Raises:
        OSError: it could not be written; what was there before is as it was.
    """
    part = path.with_name(path.name + suffix)
    with locked(path.parent):
        try:
            with part.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            if path.exists():
                on_existing(path)
            part.replace(path)
        except BaseException:
            part.unlink(missing_ok=True)  # it takes disk space that others need
            raise


def set_aside(path: Path) -> None:
    """Rename <name>.json to the first of <name>_1.json, <name>_2.json, … that there is not."""
    numbered = (path.with_stem(f"{path.stem}_{number}") for number in itertools.count(1))
    path.rename(next(each for each in numbered if not each.exists()))


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Wait while another process is in here with the same folder; where its file system has no locks, go on."""
    descriptor = None
    try:
        with suppress(OSError):
            descriptor = os.open(folder, os.O_RDONLY)
            take_lock(descriptor, waits=True)
        yield
    finally:
        if descriptor is not None:
            os.close(descriptor)


def take_lock(file: int | IO[Any], waits: bool = False) -> None:
    """Take the kernel's lock of an open file or folder, held until it is closed; without fcntl nothing is locked.

    Raises:
        BlockingIOError: another process has it, and this one does not wait.
    """
    if fcntl is not None:
        fcntl.flock(file, fcntl.LOCK_EX if waits else fcntl.LOCK_EX | fcntl.LOCK_NB)


def claim_folder(folder: Path) -> Path:
    """Make a folder of one's own: this one, or the first of <folder>_2, <folder>_3, … that there is not."""
    path, number = folder, 1
    while True:
        with suppress(FileExistsError):
            path.mkdir(parents=True)
            return path
        number += 1
        path = folder.with_name(f"{folder.name}_{number}")


@contextmanager
def closed_on_error(file: IO[Any]) -> Iterator[None]:
    """Close a file whose first lines cannot be written: Python would report that on stderr a second time."""
    try:
        yield
    except OSError:
        with suppress(OSError):  # closing tries to write the rest again
            file.close()
        raise
