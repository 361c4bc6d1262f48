"""Files that a room is made of: of bounded size, and inside the folders where they may lie."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from tasks.errors import TaskError


class UnreadError(TaskError):
    """Why a room must do without something that its file holds, half a sentence for `Room.omitted`."""


def find_within(candidates: Iterable[Path], folders: Sequence[Path]) -> Path:
    """The first path that exists, with links followed, inside one of the folders.

    Raises:
        UnreadError: no path is.
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
