"""What a run holds from after a checkpoint is taken back before the training goes on from it."""

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from asddpg.atomic_write import write_whole
from asddpg.observers.metrics_log import read_rows
from asddpg.runs import append_only_logs
from asddpg.runs.checkpoints import TrainingStates
from asddpg.runs.run_folder import RunFolder


def take_back(folder: RunFolder, state: Mapping[str, Any] | None) -> None:
    """Shorten the logs and remove recordings and weights of later steps; they will be made again.

    Args:
        folder: the run's.
        state: of the checkpoint, as TrainingStates gave it; None for the beginning.
    """
    best = state["best_weights"] if state else None
    step, episodes = (state["step"], state["episodes"]["episodes"]) if state else (0, 0)
    append_only_logs.take_back(folder.path, state["files"] if state else {})
    for path in folder.episodes.glob("*.mcap*"):
        if _episode_of(path) > episodes:
            path.unlink()
    validated = {folder.snapshot(int(row["step"])).parent for row in read_rows(folder.validation)}
    for path in folder.path.glob("checkpoints/step_*"):
        if path not in validated:
            shutil.rmtree(path)
    if best is None:
        folder.checkpoint("best").unlink(missing_ok=True)
    else:
        write_whole(folder.checkpoint("best"), best.tobytes())
    for path in (folder.test, folder.resources):
        path.unlink(missing_ok=True)
    TrainingStates(folder.training_states).forget_after(step)


def set_end_aside(folder: RunFolder, steps: int) -> None:
    """Keep, under the name of its step, the test of a run that is prolonged after its end."""
    if folder.test.exists():
        folder.test.replace(folder.test.with_name(f"test_step_{steps:08d}.json"))


def _episode_of(recording: Path) -> int:
    """Number of the episode in a recording's name, <step>_<episode>_<outcome>.mcap; 0 for other names."""
    parts = recording.name.split(".")[0].split("_")
    return int(parts[1]) if len(parts) > 1 and parts[0].isdigit() and parts[1].isdigit() else 0
