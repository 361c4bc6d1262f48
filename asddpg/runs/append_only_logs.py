"""Logs of a run, to which a training only appends: their lengths at a training state, and truncation to them."""

import hashlib
from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from asddpg.runs.state_files import DamagedStateError, file_digest, to_disk

# No other file is ever truncated or removed, whatever names a training state holds.
PATTERNS = ("metrics.csv", "timing.csv", "validation.csv", "steps.f32", "tensorboard/events.*")

_NOT_READ_BACK = ("timing.csv", "tensorboard/events.*")  # nothing is read back from them


def lengths(run: Path) -> dict[str, dict[str, Any]]:
    """Bytes and SHA-256 of each log of a run, by its path in it; all are flushed to the disk."""
    found = {}
    for path in _present(run):
        to_disk(path)
        found[str(path.relative_to(run))] = {"bytes": path.stat().st_size, "sha256": file_digest(path)}
    return found


def check(run: Path, marks: Mapping[str, Mapping[str, Any]]) -> None:
    """See that every log still begins as it did; those that nothing reads back may be gone or changed.

    Raises:
        DamagedStateError: one does not, or is no file of a run.
    """
    for name, mark in marks.items():
        path = run / name
        if not any(_is_match(name, pattern) for pattern in PATTERNS) or path.is_symlink():
            raise DamagedStateError(f"{name} is no file that a training writes")
        if any(_is_match(name, pattern) for pattern in _NOT_READ_BACK):
            continue
        if not path.is_file():
            raise DamagedStateError(f"{path}, which belongs to it, is missing")
        with path.open("rb") as file:
            beginning = file.read(mark["bytes"])
        if hashlib.sha256(beginning).hexdigest() != mark["sha256"]:
            raise DamagedStateError(f"{path}, which belongs to it, has been changed or cut")


def truncate(run: Path, marks: Mapping[str, Mapping[str, Any]]) -> None:
    """Truncate each log to its length then, and remove later ones."""
    for path in _present(run):
        mark = marks.get(str(path.relative_to(run)))
        if mark is None:
            path.unlink()
        else:
            with path.open("r+b") as file:
                file.truncate(min(mark["bytes"], path.stat().st_size))


def _present(run: Path) -> list[Path]:
    paths = [path for pattern in PATTERNS for path in sorted(run.glob(pattern))]
    return [path for path in paths if path.is_file() and not path.is_symlink()]


def _is_match(name: str, pattern: str) -> bool:
    return name.count("/") == pattern.count("/") and ".." not in name.split("/") and fnmatchcase(name, pattern)
