"""Opens a trained policy by `run=`: the folder of a run, or a pretrained policy by name."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from asddpg.algorithm.agent import AsDDPG
from asddpg.config import TrainConfig
from asddpg.errors import UserError
from asddpg.runs import weights_file
from asddpg.runs.pretrained import open_pretrained
from asddpg.runs.run_folder import open_run_folder, read_training
from asddpg.runs.safe_loading import OURS

PREFIX = "pretrained:"


@dataclass(frozen=True)
class Trained:
    """A training that can be driven.

    Attributes:
        title: what it is, for people.
        config: the configuration of the training.
        provenance: versions, and the hash of the scene.
        evaluation: where figures of it are written.
        weights: the file with the weights.
        load_into: copies the trained weights into an agent; returns the training step they are of.
    """

    title: str
    config: TrainConfig
    provenance: dict[str, str]
    evaluation: Path
    weights: Path
    load_into: Callable[[AsDDPG], int]


def open_trained(run: str, checkpoint: str = "last", controller: str | None = OURS) -> Trained:
    """Open what `run=` names.

    Args:
        run: the folder of a run, or pretrained:<name>.
        checkpoint: of a run, last or best; a pretrained policy has but one.
        controller: of a run, the type that the user has named, as in read_training.

    Raises:
        UserError: there is no such thing, or it is damaged.
    """
    if run.startswith(PREFIX):
        return _open_pretrained(run, checkpoint)
    folder = open_run_folder(run)
    config, provenance = read_training(folder.config, controller)
    weights = folder.checkpoint(checkpoint)

    def load_into(agent: AsDDPG) -> int:
        return weights_file.load_into(weights, agent.networks)

    return Trained(f"{run}, {checkpoint} checkpoint", config, provenance, folder.evaluation, weights, load_into)


def _open_pretrained(run: str, checkpoint: str) -> Trained:
    folder = open_pretrained(run.removeprefix(PREFIX))
    if checkpoint != "last":
        raise UserError(f"checkpoint={checkpoint} belongs to a run's folder; {run} has one set of weights")
    config, provenance = read_training(folder.config)

    def load_into(agent: AsDDPG) -> int:
        return weights_file.load_into(folder.weights, agent.networks)

    # Into the present folder, as a baseline's: the package is not the user's to write into.
    return Trained(run, config, provenance, Path("evaluation.json"), folder.weights, load_into)


def file_hash(path: Path) -> str:
    """SHA-256 of a file, 16 hex digits: names the weights that drove."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:16]
