"""What is kept of a training that met a number that is none: enough to make the step again."""

import json
import shutil
from pathlib import Path

import mujoco
from dm_control.rl.control import PhysicsError

from asddpg.observers.finite_check import NotFiniteError
from asddpg.program import python
from asddpg.run_folder import RunFolder, write_json
from asddpg.training_states import TrainingStates

WHAT = "what.json"
CAUSES = (NotFiniteError, PhysicsError, mujoco.FatalError)  # the last where MuJoCo's memory is full


def what_of(error: Exception) -> str:
    """What went wrong, in one line."""
    return str(error).splitlines()[0]


def write(folder: RunFolder, states: TrainingStates, step: int, what: str) -> Path:
    """Keep the run's configuration, its newest checkpoint and what went wrong, in a folder of their own.

    From the checkpoint the training comes to the same step again, to the last bit. Without one yet, from its beginning.

    Args:
        folder: the run's.
        states: its checkpoints.
        step: steps that were finished when it went wrong.
        what: went wrong.
    """
    dump = folder.path / f"breakdown_{step:08d}"
    shutil.rmtree(dump, ignore_errors=True)
    dump.mkdir()
    shutil.copy(folder.config, dump)
    newest = states.paths()[-1:]
    for path in newest:
        shutil.copytree(path, RunFolder(dump).training_states / path.name)
    write_json(dump / WHAT, {"step": step, "what": what})
    return dump


def sentence(dump: Path, step: int, what: str) -> str:
    """What a user is told."""
    return f"after step {step} {what}; the training has stopped; to see it again: {python()} -m asddpg.reproduce {dump}"


def read(dump: Path) -> tuple[int, str]:
    """The step and what went wrong.

    Raises:
        OSError, ValueError, KeyError: it is no dump.
    """
    content = json.loads((dump / WHAT).read_text(encoding="utf-8"))
    return int(content["step"]), str(content["what"])
