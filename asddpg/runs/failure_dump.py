"""The dump of a training that met NaN or an infinite number: enough to repeat the step."""

import json
import shlex
import shutil
from dataclasses import asdict, dataclass
from pathlib import Path

import mujoco
from dm_control.rl.control import PhysicsError

from asddpg.episodes.finite_check import NotFiniteError
from asddpg.errors import NumericalFailure, UserError
from asddpg.program import python
from asddpg.runs.run_folder import RunFolder, write_json
from asddpg.runs.training_states import TrainingStates

FILE = "failure.json"
CAUSES = (NotFiniteError, PhysicsError, mujoco.FatalError)  # the last where MuJoCo's memory is full


@dataclass(frozen=True)
class Failure:
    """A failure of a training."""

    step: int  # training steps made before
    message: str  # what failed, one line
    in_validation: bool


def first_line(error: Exception) -> str:
    """The first line of an error's message."""
    return str(error).splitlines()[0]


def dump(folder: RunFolder, states: TrainingStates, failure: Failure, argument: str) -> NumericalFailure:
    """Write a dump; returns the error for the user.

    `argument` joins the command that repeats the failure; it begins with a space, or is empty.
    """
    where = f"after step {failure.step}{', in a validation,' if failure.in_validation else ''}"
    sentence = f"{where} {failure.message}; the training has stopped"
    try:
        path = _write(folder, states, failure)
    except OSError as error:  # a full disk must not hide the failure
        return NumericalFailure(f"{sentence}; no dump of it could be written: {error.strerror}")
    return NumericalFailure(
        f"{sentence}; to repeat it: {python()} -m asddpg.reproduce {shlex.quote(str(path))}{argument}"
    )


def _write(folder: RunFolder, states: TrainingStates, failure: Failure) -> Path:
    """Copy the run's configuration and its newest training state into a folder of their own, with the failure.

    From that state the training reaches the same step again, to the last bit; without one, from its beginning.
    """
    path = folder.failure(failure.step)
    shutil.rmtree(path, ignore_errors=True)
    path.mkdir()
    shutil.copy(folder.config, path)
    for newest in states.paths()[-1:]:
        shutil.copytree(newest, RunFolder(path).training_states / newest.name)
    write_json(path / FILE, asdict(failure))
    return path


def read(path: Path) -> Failure:
    """The failure of a dump.

    Raises:
        UserError: it is no dump.
    """
    try:
        content = json.loads((path / FILE).read_text(encoding="utf-8"))
        return Failure(int(content["step"]), str(content["message"]), bool(content["in_validation"]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path} is not the folder of a failure: no {FILE} can be read there") from error
