"""The networks' weights on disk: written whole or not at all, read without running code.

What a training needs to go on is kept apart, in asddpg/runs/checkpoints.py.
"""

import io
import pickle
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import torch

from asddpg.algorithm.agent import AsDDPG
from asddpg.atomic_write import write_whole
from asddpg.errors import UserError
from asddpg.runs.safe_loading import check_packed

FORMAT = "asddpg-snapshot-1"
_WITH_OPTIMIZERS = "asddpg-checkpoint-1"  # of earlier versions: targets and optimisers stand beside the weights


def save(path: Path, agent: AsDDPG, step: int) -> None:
    """Write the networks' weights after `step` training steps: enough to drive, too little to train on.

    Raises:
        OSError: they could not be written; what was there before is as it was.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    content = io.BytesIO()  # torch itself says RuntimeError of a full disk
    torch.save({"format": FORMAT, "step": step, "networks": agent.networks.state_dict()}, content)
    write_whole(path, content.getbuffer())


def load(path: Path, agent: AsDDPG) -> int:
    """Give an agent's networks the weights in a checkpoint; returns the training step it was written at.

    Raises:
        UserError: the file is missing, not a checkpoint of this program, or of another network.
    """
    content = _read(path)
    try:
        weights = content["agent"]["networks"] if content["format"] == _WITH_OPTIMIZERS else content["networks"]
        agent.networks.load_state_dict(weights)
        return int(content["step"])
    except (KeyError, RuntimeError, ValueError, TypeError, AttributeError) as error:
        raise UserError(f"the checkpoint {path} does not fit the network that its run's config.yaml names") from error


def _read(path: Path) -> dict[str, Any]:
    if not path.is_file():
        raise UserError(f"there is no checkpoint {path}")
    try:
        check_packed(path, largest=path.stat().st_size)  # torch.save packs nothing
        content = torch.load(path, map_location="cpu", weights_only=True)
    except (BadZipFile, pickle.UnpicklingError, RuntimeError, EOFError, ValueError, KeyError, OSError) as error:
        raise UserError(f"{path} is damaged or not a checkpoint written by asddpg.train") from error
    if not isinstance(content, dict) or content.get("format") not in (FORMAT, _WITH_OPTIMIZERS):
        raise UserError(f"{path} is not a checkpoint written by asddpg.train")
    return content
