"""Pretrained policies by name: models/pretrained/<name>/."""

from pathlib import Path

import numpy as np
import torch

from asddpg.algorithm.networks import Networks
from asddpg.config import TrainConfig
from asddpg.episodes.protocols import Action, Observation
from asddpg.errors import UserError
from asddpg.runs import weights_file
from asddpg.runs.run_folder import read_training
from tasks.scene.loading import MODELS

FOLDER = MODELS.parent / "pretrained"


class PretrainedFolder:
    """Paths of a pretrained policy."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.weights = path / "policy.safetensors"  # of policy and switch
        self.config = path / "config.yaml"  # resolved configuration of the training, and its provenance
        self.card = path / "card.md"  # how it was trained, its results, where it fails, how to use it
        self.test = path / "test.json"  # results on the stored test pairs, the outcome of each, every failure


class Policy:
    """A trained policy, alone: no noise, no switch, no controller.

    Attributes:
        config: the configuration it was trained with.
        step: of the training that the weights are of.
    """

    def __init__(self, networks: Networks, config: TrainConfig, step: int, observation_size: int) -> None:
        """Wrap trained networks on the CPU, whose policy reads observations of that length."""
        self._networks, self._observation_size = networks, observation_size
        self.config, self.step = config, step

    @torch.no_grad()
    def act(self, observation: Observation) -> Action:
        """π(x): float32 (action_size,), physical units, from a flat observation, float32 (observation_size,).

        Raises:
            ValueError: the observation has another shape.
        """
        if np.shape(observation) != (self._observation_size,):
            raise ValueError(
                f"an observation must have the shape ({self._observation_size},), not {np.shape(observation)}"
            )
        batch = torch.from_numpy(np.asarray(observation, dtype=np.float32))[None]
        action: Action = self._networks.policy(batch)[0].numpy()
        return action


def names() -> list[str]:
    """The pretrained policies there are."""
    return sorted(path.name for path in FOLDER.glob("[!.]*") if PretrainedFolder(path).weights.is_file())


def open_pretrained(name: str) -> PretrainedFolder:
    """The folder of a pretrained policy.

    Raises:
        UserError: there is none of that name.
    """
    if name not in names():
        raise UserError(f"there is no pretrained policy {name!r}; there are {', '.join(names()) or 'none yet'}")
    return PretrainedFolder(FOLDER / name)


def load_policy(name: str) -> Policy:
    """A pretrained policy by name, such as nav_complex.

    Raises:
        UserError: there is none of that name, or its files are damaged.
    """
    folder = open_pretrained(name)
    config, _ = read_training(folder.config)
    networks, step, observation_size = weights_file.read(folder.weights)
    return Policy(networks, config, step, observation_size)
