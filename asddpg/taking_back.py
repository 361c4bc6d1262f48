"""What a run holds from after a checkpoint is taken back before the training goes on from it."""

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from asddpg import growing_files
from asddpg.run_folder import RunFolder
from asddpg.training_states import TrainingStates


def take_back(folder: RunFolder, state: Mapping[str, Any] | None) -> None:
    """Shorten the logs and remove recordings and weights of later steps; they will be made again.

    Args:
        folder: the run's.
        state: of the checkpoint, as TrainingStates gave it; None for the beginning.
    """
    step, episodes = (state["step"], state["episodes"]["episodes"]) if state else (0, 0)
    growing_files.take_back(folder.path, state["files"] if state else {})
    for path in folder.episodes.glob("*.mcap*"):
        if _episode_of(path) > episodes:
            path.unlink()
    for path in folder.snapshots():
        if path > folder.snapshot(step):
            shutil.rmtree(path.parent)
    _restore(folder.checkpoint("best"), state["best_file"] if state else None)
    for path in (folder.test, folder.resources):
        path.unlink(missing_ok=True)
    TrainingStates(folder.training_states).forget_after(step)


def _restore(best: Path, content: npt.NDArray[np.uint8] | None) -> None:
    """The weights that were best then: those that were best later are of a future that may not come."""
    if content is None:
        best.unlink(missing_ok=True)
        return
    best.parent.mkdir(parents=True, exist_ok=True)
    part = best.with_name(best.name + ".part")
    part.write_bytes(content.tobytes())
    part.replace(best)


def _episode_of(recording: Path) -> int:
    """Number of the episode in a recording's name, <step>_<episode>_<outcome>.mcap; 0 for other names."""
    parts = recording.name.split(".")[0].split("_")
    return int(parts[1]) if len(parts) > 1 and parts[0].isdigit() and parts[1].isdigit() else 0
