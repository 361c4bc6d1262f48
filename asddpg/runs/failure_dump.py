"""What is kept of a training that met a number that is none: enough to make the step again."""

import json
import shlex
import shutil
from dataclasses import asdict, dataclass
from pathlib import Path

import mujoco
from dm_control.rl.control import PhysicsError

from asddpg.errors import Breakdown
from asddpg.observers.finite_check import NotFiniteError
from asddpg.program import python
from asddpg.runs.checkpoints import TrainingStates
from asddpg.runs.run_folder import RunFolder, write_json

WHAT = "what.json"
CAUSES = (NotFiniteError, PhysicsError, mujoco.FatalError)  # the last where MuJoCo's memory is full


def first_line(error: Exception) -> str:
    """What went wrong, in one line."""
    return str(error).splitlines()[0]


@dataclass(frozen=True)
class Trouble:
    """What broke a training: after how many steps, what, and whether while it validated."""

    step: int
    what: str
    in_validation: bool


def stopped(folder: RunFolder, states: TrainingStates, trouble: Trouble, named: str) -> Breakdown:
    """Keep a dump, and give what a user is told; `named` are words that the command to see it again needs besides."""
    when = f"after step {trouble.step}{', in a validation,' if trouble.in_validation else ''}"
    broke = f"{when} {trouble.what}; the training has stopped"
    try:
        dump = _write(folder, states, trouble)
    except OSError as error:  # a full disk must not hide what broke
        return Breakdown(f"{broke}; no dump of it could be written: {error.strerror}")
    return Breakdown(f"{broke}; to see it again: {python()} -m asddpg.reproduce {shlex.quote(str(dump))}{named}")


def _write(folder: RunFolder, states: TrainingStates, trouble: Trouble) -> Path:
    """Keep the run's configuration, its newest checkpoint and what went wrong, in a folder of their own.

    From the checkpoint the training comes to the same step again, to the last bit. Without one yet, from its beginning.

    """
    dump = folder.path / f"breakdown_{trouble.step:08d}"
    shutil.rmtree(dump, ignore_errors=True)
    dump.mkdir()
    shutil.copy(folder.config, dump)
    newest = states.paths()[-1:]
    for path in newest:
        shutil.copytree(path, RunFolder(dump).training_states / path.name)
    write_json(dump / WHAT, asdict(trouble))
    return dump


def read(dump: Path) -> Trouble:
    """What broke.

    Raises:
        OSError, ValueError, KeyError, TypeError: it is no dump.
    """
    content = json.loads((dump / WHAT).read_text(encoding="utf-8"))
    return Trouble(int(content["step"]), str(content["what"]), bool(content["in_validation"]))
