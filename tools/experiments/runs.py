"""Training runs: what each is trained with, and the digest that names its folder.

The digest is taken of the options that differ from their defaults, so a new option that is off by default changes none.
"""

import functools
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from asddpg.command_line import train_config
from asddpg.config import TrainConfig
from asddpg.options.parsing import flatten
from tasks.laser import BeamRing
from tasks.scene.loading import load_model, model_hash, scene_path

# Validations in every run, however long it is, so that figures over the last five of them mean the same.
VALIDATIONS = 20
# Options that change nothing that is learned: where a run lies, how often it is kept, what is recorded and shown.
WITHOUT_EFFECT = ("run_dir", "checkpoint_every", "record", "live", "port", "speed")
DIGITS = 12  # of a digest


@dataclass(frozen=True)
class Run:
    """A run to train."""

    title: str
    arguments: tuple[str, ...]
    config: TrainConfig

    @property
    def digest(self) -> str:
        """Digest of its configuration."""
        return digest(asdict(self.config))

    @property
    def name(self) -> str:
        """Name of its folder."""
        return f"{self.config.task.name}_{self.config.agent.name}_seed{self.config.seed}_{self.digest}"


@dataclass(frozen=True)
class Group:
    """Runs that differ in their seed alone, and the name of the group that an ablation measures them against."""

    title: str
    arguments: tuple[str, ...]
    steps: int
    seeds: Sequence[int]
    reference: str | None = None

    @property
    def options(self) -> tuple[str, ...]:
        """Arguments of `python -m asddpg.train` that its runs share."""
        every = max(1, self.steps // VALIDATIONS)
        return (f"total_steps={self.steps}", f"validation.every={every}", *self.arguments)

    @property
    def config(self) -> TrainConfig:
        """Configuration that its runs share; UserError where an argument is invalid."""
        return _compose(self.options)

    @property
    def digest(self) -> str:
        """Digest of that configuration: equal for groups of the same runs."""
        return digest(asdict(self.config))

    def run(self, seed: int) -> Run:
        """The run of one seed."""
        config = replace(self.config, seed=seed)
        return Run(f"{self.title}, seed {seed}", (*self.options, f"seed={seed}"), config)


_compose = functools.cache(train_config)


def digest(options: Mapping[str, Any]) -> str:
    """Digest of a configuration, given as nested dictionaries."""
    text = json.dumps(differences(options), sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:DIGITS]


def differences(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options that bear on the learning and differ from TrainConfig's defaults, by full name such as agent.gamma."""
    defaults = flatten(asdict(TrainConfig()))
    return {
        name: value
        for name, value in flatten(options).items()
        if name.partition(".")[0] not in WITHOUT_EFFECT and (name not in defaults or value != defaults[name])
    }


@functools.cache
def current_scene(task_name: str, ring: BeamRing) -> str:
    """Hash of a task's compiled scene, as asddpg.train notes it: figures of another scene are another experiment's."""
    return model_hash(load_model(scene_path(task_name), ring))
