"""Files that a room is made of: of bounded size, and inside the folders where they may lie."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from tasks.errors import TaskError

MAX_BYTES = 20_000_000  # of one file


class UnreadError(TaskError):
    """Why a room must do without something that its file holds, half a sentence for `Room.omitted`."""


def read_file(path: Path) -> bytes:
    """The bytes of a regular file.

    Raises:
        TaskError: no such file, it cannot be read, or it is larger than MAX_BYTES.
    """
    try:
        if not path.is_file():
            raise TaskError(f"there is no file {path}")
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except TaskError:
        raise
    except (OSError, RuntimeError, ValueError) as error:  # a name too long, a circle of links, a zero byte
        raise TaskError(f"the file {str(path)[:200]} cannot be read: {error}") from error
    if len(data) > MAX_BYTES:
        raise TaskError(f"the file {path} is larger than {MAX_BYTES // 1_000_000} MB")
    return data


def find_within(candidates: Iterable[Path], folders: Sequence[Path]) -> Path:
    """The first path that exists, with links followed, inside one of the folders.

    Raises:
        UnreadError: there is none.
    """
    is_outside = False
    roots = [folder.resolve() for folder in folders]
    for candidate in candidates:
        try:
            found = candidate.resolve(strict=True)
        except (OSError, RuntimeError, ValueError):
            continue
        if any(found.is_relative_to(root) for root in roots):
            return found
        is_outside = True
    where = ", ".join(str(folder) for folder in folders)
    raise UnreadError(f"it lies outside of {where}" if is_outside else f"it is not in {where}")
