"""A run's folder: what lies where, made new, read back."""

import itertools
import json
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import yaml

from asddpg.atomic_write import write_whole
from asddpg.command_line import stored_config
from asddpg.config import TrainConfig
from asddpg.errors import UserError
from asddpg.runs.safe_loading import OURS, beginning_of, check_controller, check_links, plain_values
from tasks import ALL_TASKS


@dataclass(frozen=True)
class RunFolder:
    """Paths of a run.

    `config.yaml` resolved configuration and what the run was made with · `metrics.csv` a row an episode ·
    `validation.csv` a row a validation · `episodes/` recordings of the training, `evaluated_episodes/` of evaluations,
    `played_episodes/` of those that were played ·
    `timing.csv`, `resources.json` time and memory · `tensorboard/` · `steps.f32`, `steps.npz` a row a training
    step · `resume/step_<n>/` what the training goes on from · `breakdown_<step>/` what broke it ·
    `lock` names the process that writes the run ·
    `checkpoints/{last,best}/agent.pt`, and `checkpoints/step_<n>/agent.pt` at each validation · `test.json` the test
    that ends the training · `evaluation.json` what asddpg.evaluate found last · `diagnosis/` what tools.diagnose found.
    """

    path: Path

    @property
    def config(self) -> Path:
        """Resolved configuration."""
        return self.path / "config.yaml"

    @property
    def metrics(self) -> Path:
        """A row an episode."""
        return self.path / "metrics.csv"

    @property
    def validation(self) -> Path:
        """A row a validation."""
        return self.path / "validation.csv"

    @property
    def steps(self) -> Path:
        """A row a training step, in arrays."""
        return self.path / "steps.npz"

    @property
    def timing(self) -> Path:
        """Wall-clock time, kept apart: nothing else depends on the clock."""
        return self.path / "timing.csv"

    @property
    def tensorboard(self) -> Path:
        """TensorBoard's files."""
        return self.path / "tensorboard"

    @property
    def test(self) -> Path:
        """Figures of the test that ends a training, of both checkpoints."""
        return self.path / "test.json"

    @property
    def evaluation(self) -> Path:
        """Figures of the last evaluation."""
        return self.path / "evaluation.json"

    @property
    def episodes(self) -> Path:
        """Folder of the training's recordings."""
        return self.path / "episodes"

    @property
    def step_rows(self) -> Path:
        """The same rows one after the other, float32: they grow with the training."""
        return self.path / "steps.f32"

    @property
    def training_states(self) -> Path:
        """Folder of the checkpoints from which the training goes on."""
        return self.path / "resume"

    @property
    def resources(self) -> Path:
        """Time and memory the run took."""
        return self.path / "resources.json"

    def checkpoint(self, name: str) -> Path:
        """Weights; `name` is last or best."""
        return self.path / "checkpoints" / name / "agent.pt"

    def snapshot(self, step: int) -> Path:
        """The networks' weights at a validation, after `step` training steps."""
        return self.checkpoint(f"step_{step:08d}")

    def snapshots(self) -> list[Path]:
        """All snapshots, oldest first."""
        return sorted(self.path.glob("checkpoints/step_*/agent.pt"))

    @property
    def diagnosis(self) -> Path:
        """Folder of what tools.diagnose made."""
        return self.path / "diagnosis"

    def create(self) -> None:
        """Make the folder.

        Raises:
            UserError: it cannot be made.
        """
        try:
            for name in ("last", "best"):
                self.checkpoint(name).parent.mkdir(parents=True)
        except OSError as error:
            raise UserError(f"the run folder {self.path} cannot be made: {error.strerror}") from error


def new_run_folder(config: TrainConfig) -> RunFolder:
    """The folder a configuration asks for, not yet made.

    Raises:
        UserError: it exists and is not empty.
    """
    name = f"{datetime.now():%Y-%m-%d_%H-%M-%S}_{config.task.name}_{config.agent.name}_seed{config.seed}"
    path = Path(config.run_dir) if config.run_dir else Path("runs") / name
    if path.exists() and (not path.is_dir() or any(path.iterdir())):
        raise UserError(f"the run folder {path} exists and is not empty; choose another run_dir= or remove it")
    return RunFolder(path)


def unused_folder(folder: Path) -> Path:
    """A folder for recordings, or, where it holds some already, the first of <folder>_2, _3, … that does not."""
    numbered = (folder.with_name(f"{folder.name}_{number}") for number in itertools.count(2))
    return next(path for path in itertools.chain([folder], numbered) if not path.is_dir() or not any(path.iterdir()))


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


def config_text(config: dict[str, Any], provenance: dict[str, str]) -> str:
    """What stands in a config.yaml: the resolved configuration, and versions and model hash under `provenance`."""
    text: str = yaml.safe_dump({**config, "provenance": provenance}, sort_keys=False, allow_unicode=True)
    return text


def read_training(path: Path, controller: str | None = OURS) -> tuple[TrainConfig, dict[str, str]]:
    """The configuration of a training, checked, and what it was made with.

    Args:
        path: of the file.
        controller: the type of controller that the user has named: a file makes no other than this project's run.
            None where none is going to be made.

    Raises:
        UserError: the file is damaged, or of a version with other options or tasks, or names another controller.
    """
    return training_in(beginning_of(path), str(path), controller)


def training_in(text: str | bytes, title: str, controller: str | None = OURS) -> tuple[TrainConfig, dict[str, str]]:
    """The same of the text of a config.yaml, which errors call by a title.

    Raises:
        UserError: as above.
    """
    values, provenance = _values_in(text, title)
    try:
        config = stored_config(values)
    except UserError as error:
        raise UserError(f"{title} is not a configuration of this version: {error}") from error
    if config.task.name not in ALL_TASKS:
        raise UserError(f"{title} names no task of this version: {config.task.name!r}")
    check_controller(config, controller, title)
    return config, provenance


def read_config(path: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """The values in a config.yaml as they stand there, and what the training was made with.

    Raises:
        UserError: the file is damaged.
    """
    return _values_in(beginning_of(path), str(path))


def _values_in(text: str | bytes, title: str) -> tuple[dict[str, Any], dict[str, str]]:
    try:
        values = plain_values(text)
        provenance = {str(name): str(version) for name, version in values.pop("provenance").items()}
    except (ValueError, AttributeError, LookupError, TypeError) as error:
        raise UserError(f"{title} is damaged or not written by asddpg.train") from error
    return values, provenance


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a file that is whole or not there."""
    write_text(path, json.dumps(content, indent=2, allow_nan=False) + "\n")


def write_text(path: Path, text: str) -> None:
    """Write a file that is whole or, if there was one before, the one before."""
    write_whole(path, text.encode())
