"""Recordings that a command line names: files, and those in folders."""

from collections.abc import Iterable
from pathlib import Path

from asddpg.errors import UserError
from asddpg.recording.files.reading import Recording, open_recording

# Folders of a run that hold recordings.
RUN_FOLDERS = ("episodes", "evaluated_episodes", "played_episodes")


def files_named(paths: Iterable[Path]) -> list[Path]:
    """Recordings by paths: a file each, or all of a folder, a run's too, in their order in time.

    Raises:
        UserError: there is no such file, or a folder has no recordings.
    """
    return [file for path in paths for file in _files(path)]


def open_single(path: Path) -> Recording:
    """The recording of a file, or of a folder that holds one.

    Raises:
        UserError: as above, or the folder holds several.
    """
    files = _files(path)
    if len(files) > 1:
        raise UserError(f"name one recording, not {len(files)}: {files[0]}, {files[1]}{', …' * (len(files) > 2)}")
    return open_recording(files[0])


def _files(path: Path) -> list[Path]:
    if not path.is_dir():
        if not path.exists():
            raise UserError(f"there is no file or folder {path}; recordings end in .mcap")
        return [path]
    files = sorted(path.glob("*.mcap")) or sorted(
        file for inner in RUN_FOLDERS for file in path.glob(f"{inner}/*.mcap")
    )
    if not files:
        below = sorted({found.parent for found in path.rglob("*.mcap")})
        hint = f"; there are some in {below[0]}" if below else ""
        raise UserError(f"there are no recordings (*.mcap) in {path}{hint}")
    return files
