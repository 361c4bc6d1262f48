"""Recordings by the words of a command line: files, and what lies in folders."""

from collections.abc import Iterable
from pathlib import Path

from asddpg.errors import UserError

# Where a run's folder has its recordings.
OF_A_RUN = ("episodes", "evaluated_episodes", "played_episodes")


def files_named(arguments: Iterable[str]) -> list[Path]:
    """The recordings that words name: a file each, or all of a folder, a run's too, in their order in time.

    Raises:
        UserError: there is no such file, or a folder has no recordings.
    """
    return [path for argument in arguments for path in _files(Path(argument))]


def _files(path: Path) -> list[Path]:
    if not path.is_dir():
        if not path.exists():
            raise UserError(f"there is no file or folder {path}; recordings end in .mcap")
        return [path]
    files = sorted(path.glob("*.mcap")) or sorted(file for inner in OF_A_RUN for file in path.glob(f"{inner}/*.mcap"))
    if not files:
        below = sorted({found.parent for found in path.rglob("*.mcap")})
        hint = f"; there are some in {below[0]}" if below else ""
        raise UserError(f"there are no recordings (*.mcap) in {path}{hint}")
    return files
