"""Rewinds a run's folder to a training state: what is of later steps goes, before the training resumes from it.

A training only appends to its logs; a training state holds their lengths, to which they are truncated.
"""

import hashlib
from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from asddpg.atomic_write import write_whole
from asddpg.observers.metrics_log import read_rows
from asddpg.recording.files.recovery import complete_interrupted
from asddpg.runs.run_folder import RunFolder
from asddpg.runs.state_files import DamagedStateError, file_digest, to_disk
from asddpg.runs.training_states import TrainingStates

# No other file is ever truncated or removed, whatever names a training state holds.
PATTERNS = ("metrics.csv", "timing.csv", "validation.csv", "steps.f32", "tensorboard/events.*")

_NOT_READ_BACK = ("timing.csv", "tensorboard/events.*")  # nothing is read back from them


def log_lengths(run: Path) -> dict[str, dict[str, Any]]:
    """Bytes and SHA-256 of each log of a run, by its path in it; all are flushed to the disk."""
    found = {}
    for path in _present(run):
        to_disk(path)
        found[str(path.relative_to(run))] = {"bytes": path.stat().st_size, "sha256": file_digest(path)}
    return found


def check_logs(run: Path, marks: Mapping[str, Mapping[str, Any]]) -> None:
    """Check that every log still begins as it did; those that nothing reads back may be gone or changed.

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


def rewind(folder: RunFolder, state: Mapping[str, Any] | None) -> None:
    """Truncate the logs; remove recordings and weights of later steps, which will be made again.

    Args:
        folder: the run's.
        state: a training state as TrainingStates returned it; None for the beginning.
    """
    _truncate_logs(folder.path, state["files"] if state else {})
    _rewind_recordings(folder, state)
    _rewind_weights(folder, state["best_weights"] if state else None)
    for path in (folder.test, folder.resources):
        path.unlink(missing_ok=True)
    TrainingStates(folder.training_states).forget_after(state["step"] if state else 0)


def keep_test(folder: RunFolder, steps: int) -> None:
    """Keep, under the name of its step, the test of a run that is prolonged after its end."""
    if folder.test.exists():
        folder.test.replace(folder.test.with_name(f"test_step_{steps:08d}.json"))


def _truncate_logs(run: Path, marks: Mapping[str, Mapping[str, Any]]) -> None:
    """Truncate each log to its length at the training state, and remove later ones."""
    for path in _present(run):
        mark = marks.get(str(path.relative_to(run)))
        if mark is None:
            path.unlink()
        else:
            with path.open("r+b") as file:
                file.truncate(min(mark["bytes"], path.stat().st_size))


def _rewind_recordings(folder: RunFolder, state: Mapping[str, Any] | None) -> None:
    """Remove those of later episodes; that of the episode in progress, which resumes unrecorded, ends as cut."""
    episodes = state["episodes"] if state else None
    newest = int(episodes["numbers"][0]) if episodes else 0  # of robot 0, which is recorded
    for path in sorted(folder.episodes.glob("*.mcap*")):
        episode = _episode_number(path)
        if episode > newest:
            path.unlink()
        elif path.suffix == ".part" and episodes and episodes["in_progress"][0]:
            complete_interrupted(path)


def _rewind_weights(folder: RunFolder, best: Any) -> None:
    validated = {folder.snapshot(int(row["step"])) for row in read_rows(folder.validation)}
    for path in folder.snapshots():
        if path not in validated:
            path.unlink()
    if best is None:
        folder.checkpoint("best").unlink(missing_ok=True)
    else:
        write_whole(folder.checkpoint("best"), best.tobytes())


def _present(run: Path) -> list[Path]:
    paths = [path for pattern in PATTERNS for path in sorted(run.glob(pattern))]
    return [path for path in paths if path.is_file() and not path.is_symlink()]


def _is_match(name: str, pattern: str) -> bool:
    return name.count("/") == pattern.count("/") and ".." not in name.split("/") and fnmatchcase(name, pattern)


def _episode_number(recording: Path) -> int:
    """Number of the episode in a recording's name, <step>_<episode>_<outcome>.mcap; 0 for other names."""
    parts = recording.name.split(".")[0].split("_")
    return int(parts[1]) if len(parts) > 1 and parts[0].isdigit() and parts[1].isdigit() else 0
