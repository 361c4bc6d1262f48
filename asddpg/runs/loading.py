"""Opens a trained policy by `run=`: the folder of a run, or a pretrained policy by name."""

from dataclasses import dataclass
from pathlib import Path

from asddpg.config import TrainConfig
from asddpg.errors import UserError
from asddpg.runs.pretrained import open_pretrained
from asddpg.runs.run_folder import open_run_folder, read_training
from asddpg.runs.safe_loading import OURS

PREFIX = "pretrained:"


@dataclass(frozen=True)
class Trained:
    """A trained policy on the disk."""

    title: str
    config: TrainConfig
    provenance: dict[str, str]
    out: Path  # folder for what is made with it
    weights: Path


def open_trained(run: str, checkpoint: str = "last", controller: str | None = OURS) -> Trained:
    """Open what `run=` names.

    Args:
        run: the folder of a run, or pretrained:<name>.
        checkpoint: of a run, last or best; a pretrained policy has but one.
        controller: of a run, the type that the user has named, as in read_training.

    Raises:
        UserError: there is no such thing, or it is damaged.
    """
    if not run.startswith(PREFIX):
        folder = open_run_folder(run)
        training = read_training(folder.config, controller)
        return Trained(f"{run}, {checkpoint} checkpoint", *training, folder.path, folder.checkpoint(checkpoint))
    shipped = open_pretrained(run.removeprefix(PREFIX))
    if checkpoint != "last":
        raise UserError(f"checkpoint={checkpoint} belongs to a run's folder; {run} has one set of weights")
    # Into the present folder, as a baseline's: the package is not the user's to write into.
    return Trained(run, *read_training(shipped.config), Path(), shipped.weights)
