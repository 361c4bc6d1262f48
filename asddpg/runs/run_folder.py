"""A run's folder: its paths, how it is created and read."""

import json
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Any

import yaml

from asddpg.atomic_write import claim_folder, set_aside, write_whole
from asddpg.command_line import stored_config
from asddpg.config import TrainConfig
from asddpg.errors import UserError
from asddpg.runs.safe_loading import LARGEST_CONFIG, OURS, check_controller, check_links, plain_values
from tasks import ALL_TASKS
from tasks.rooms.reading import is_room, short_name


class RunFolder:
    """Paths of a run."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.config = path / "config.yaml"  # resolved configuration and provenance
        self.metrics = path / "metrics.csv"  # a row an episode
        self.validation = path / "validation.csv"  # a row a validation
        self.step_rows = path / "steps.f32"  # a row a training step, float32: it grows with the training
        self.steps = path / "steps.npz"  # the same as named arrays
        self.timing = path / "timing.csv"  # wall-clock time, kept apart: nothing else depends on the clock
        self.tensorboard = path / "tensorboard"
        self.training_states = path / "resume"  # step_<n>/, from which a training resumes
        self.episodes = path / "episodes"  # recordings of the training
        self.test = path / "test.json"  # results of the test that ends the training, of both checkpoints
        self.resources = path / "resources.json"  # time and memory that the training took
        self.pairs = path / "pairs.json"  # evaluation sets of a room that is a file or is generated
        self.evaluation = path / "evaluation.json"  # results of the last evaluation
        self.diagnosis = path / "diagnosis"  # of tools.diagnose

    def checkpoint(self, name: str) -> Path:
        """Weights; `name` is last or best."""
        return self.path / "checkpoints" / f"{name}.safetensors"

    def snapshot(self, step: int) -> Path:
        """Weights at a validation, after `step` training steps."""
        return self.checkpoint(f"step_{step:08d}")

    def snapshots(self) -> list[Path]:
        """All snapshots, oldest first."""
        return sorted(self.path.glob("checkpoints/step_*.safetensors"))

    def failure(self, step: int) -> Path:
        """Folder of the dump of a failure after `step` training steps."""
        return self.path / f"failure_{step:08d}"

    def write_config(self, config: TrainConfig, provenance: dict[str, str]) -> None:
        """Write config.yaml, whole or, if there was one before, the one before."""
        write_whole(self.config, config_text(config, provenance).encode())


def check_unused(run_dir: str | None) -> None:
    """UserError where a folder for a new run exists and is not empty."""
    path = Path(run_dir) if run_dir else None
    if path is not None and path.exists() and (not path.is_dir() or any(path.iterdir())):
        raise UserError(f"the run folder {path} exists and is not empty; choose another run_dir= or remove it")


def create_run(config: TrainConfig) -> RunFolder:
    """Make the folder for a configuration, which no other process has.

    Raises:
        UserError: it cannot be made, or another training has just begun in it.
    """
    name = f"{datetime.now():%Y-%m-%d_%H-%M-%S}_{short_name(config.task.name)}_{config.agent.name}_seed{config.seed}"
    path = Path(config.run_dir or Path("runs") / name)
    try:
        folder = RunFolder(path if config.run_dir else claim_folder(path))
        folder.checkpoint("last").parent.mkdir(parents=True)
    except FileExistsError as error:
        raise UserError(f"another training has begun in {path}; choose another run_dir=") from error
    except OSError as error:
        raise UserError(f"the run folder {path} cannot be made: {error.strerror}") from error
    return folder


def open_run_folder(path: str) -> RunFolder:
    """The folder of a run that was made before.

    Raises:
        UserError: it is not one, or leads out of itself.
    """
    folder = RunFolder(Path(path))
    if not folder.config.is_file():
        raise UserError(f"{path or 'nothing'} is not the folder of a run: it has no config.yaml")
    check_links(folder.path)
    return folder


def config_text(config: TrainConfig, provenance: dict[str, str]) -> str:
    """Text of a config.yaml: the resolved configuration, and versions and model hash under `provenance`."""
    values = {**asdict(config), "provenance": provenance}
    text: str = yaml.safe_dump(values, sort_keys=False, allow_unicode=True)
    return text


def read_training(path: Path, controller: str | None = OURS) -> tuple[TrainConfig, dict[str, str]]:
    """The configuration of a training, checked, and its provenance.

    Args:
        path: of the file.
        controller: the type of controller that the user has named: a file may name no other code to run.
            None where no controller is made.

    Raises:
        UserError: the file is damaged, or of a version with other options or tasks, or names another controller.
    """
    return parse_training(_read(path), str(path), controller)


def parse_training(text: str | bytes, title: str, controller: str | None = OURS) -> tuple[TrainConfig, dict[str, str]]:
    """As read_training, from the text of a config.yaml, which errors call by a title."""
    values, provenance = _parse(text, title)
    try:
        config = stored_config(values)
    except UserError as error:
        raise UserError(f"{title} is not a configuration of this version: {error}") from error
    if config.task.name not in ALL_TASKS and not is_room(config.task.name):
        raise UserError(f"{title} names no task of this version: {config.task.name!r}")
    check_controller(config, controller, title)
    return config, provenance


def read_config(path: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """The values in a config.yaml, unchecked, and the provenance of the training.

    Raises:
        UserError: the file is damaged.
    """
    return _parse(_read(path), str(path))


def _read(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(LARGEST_CONFIG + 1)


def _parse(text: str | bytes, title: str) -> tuple[dict[str, Any], dict[str, str]]:
    try:
        values = plain_values(text)
        provenance = {str(name): str(version) for name, version in values.pop("provenance").items()}
    except (ValueError, AttributeError, LookupError, TypeError) as error:
        raise UserError(f"{title} is damaged or not written by asddpg.train") from error
    return values, provenance


def write_json(path: Path, content: dict[str, Any], keeps_old: bool = False) -> None:
    """Write a file that is whole or not there; with `keeps_old` one that differs goes on as <name>_1.json and so on."""
    text = (json.dumps(content, indent=2, allow_nan=False) + "\n").encode()
    write_whole(path, text, lambda old: set_aside(old) if keeps_old and old.read_bytes() != text else None)
