"""Rewinds a run's folder to a training state: what is of later steps goes, before the training resumes from it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from asddpg.atomic_write import write_whole
from asddpg.observers.metrics_log import read_rows
from asddpg.recording.files.recovery import complete_interrupted
from asddpg.runs import append_only_logs
from asddpg.runs.run_folder import RunFolder
from asddpg.runs.training_states import TrainingStates


def rewind(folder: RunFolder, state: Mapping[str, Any] | None) -> None:
    """Truncate the logs; remove recordings and weights of later steps, which will be made again.

    Args:
        folder: the run's.
        state: a training state as TrainingStates returned it; None for the beginning.
    """
    append_only_logs.truncate(folder.path, state["files"] if state else {})
    _rewind_recordings(folder, state)
    _rewind_weights(folder, state["best_weights"] if state else None)
    for path in (folder.test, folder.resources):
        path.unlink(missing_ok=True)
    TrainingStates(folder.training_states).forget_after(state["step"] if state else 0)


def _rewind_recordings(folder: RunFolder, state: Mapping[str, Any] | None) -> None:
    """Remove those of later episodes; that of the episode in progress, which resumes unrecorded, ends as cut."""
    finished = state["episodes"]["finished_episodes"] if state else 0
    in_progress = finished + 1 if state and state["episodes"]["episode"] else None
    for path in sorted(folder.episodes.glob("*.mcap*")):
        episode = _episode_number(path)
        if episode == in_progress:
            if path.suffix == ".part":
                complete_interrupted(path)
        elif episode > finished:
            path.unlink()


def _rewind_weights(folder: RunFolder, best: Any) -> None:
    validated = {folder.snapshot(int(row["step"])) for row in read_rows(folder.validation)}
    for path in folder.snapshots():
        if path not in validated:
            path.unlink()
    if best is None:
        folder.checkpoint("best").unlink(missing_ok=True)
    else:
        write_whole(folder.checkpoint("best"), best.tobytes())


def keep_test(folder: RunFolder, steps: int) -> None:
    """Keep, under the name of its step, the test of a run that is prolonged after its end."""
    if folder.test.exists():
        folder.test.replace(folder.test.with_name(f"test_step_{steps:08d}.json"))


def _episode_number(recording: Path) -> int:
    """Number of the episode in a recording's name, <step>_<episode>_<outcome>.mcap; 0 for other names."""
    parts = recording.name.split(".")[0].split("_")
    return int(parts[1]) if len(parts) > 1 and parts[0].isdigit() and parts[1].isdigit() else 0
