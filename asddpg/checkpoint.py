"""Weights on disk: written whole or not at all, read without running code."""

import pickle
from pathlib import Path
from typing import Any

import torch

from asddpg.agent import AsDDPG
from asddpg.errors import UserError

FORMAT = "asddpg-checkpoint-1"


def save(path: Path, agent: AsDDPG, step: int) -> None:
    """Write an agent's state after `step` training steps."""
    part = path.with_name(path.name + ".part")
    torch.save({"format": FORMAT, "step": step, "agent": agent.state()}, part)
    part.replace(path)


def load(path: Path, agent: AsDDPG) -> int:
    """Give an agent the state in a checkpoint; returns the training step it was written at.

    Raises:
        UserError: the file is missing, not a checkpoint of this program, or of another network.
    """
    content = _read(path)
    try:
        agent.load_state(content["agent"])
        return int(content["step"])
    except (KeyError, RuntimeError, ValueError, TypeError, AttributeError) as error:
        raise UserError(f"the checkpoint {path} does not fit the network that its run's config.yaml names") from error


def _read(path: Path) -> dict[str, Any]:
    if not path.is_file():
        raise UserError(f"there is no checkpoint {path}")
    try:
        content = torch.load(path, map_location="cpu", weights_only=True)
    except (pickle.UnpicklingError, RuntimeError, EOFError, ValueError, KeyError, OSError) as error:
        raise UserError(f"{path} is damaged or not a checkpoint written by asddpg.train") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise UserError(f"{path} is not a checkpoint written by asddpg.train")
    return content
