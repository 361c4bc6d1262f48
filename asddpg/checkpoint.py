"""Weights on disk: written whole or not at all, read without running code."""

import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import torch

from asddpg.agent import AsDDPG
from asddpg.errors import UserError
from asddpg.strangers import check_packed

FORMAT = "asddpg-checkpoint-1"
SNAPSHOT_FORMAT = "asddpg-snapshot-1"


def save(path: Path, agent: AsDDPG, step: int) -> None:
    """Write an agent's state after `step` training steps."""
    _write(path, {"format": FORMAT, "step": step, "agent": agent.state()})


def save_snapshot(path: Path, agent: AsDDPG, step: int) -> None:
    """Write the networks' weights after `step` training steps and no more: enough to drive, too little to train on."""
    path.parent.mkdir(exist_ok=True)
    _write(path, {"format": SNAPSHOT_FORMAT, "step": step, "networks": agent.networks.state_dict()})


def _write(path: Path, content: dict[str, Any]) -> None:
    part = path.with_name(path.name + ".part")
    torch.save(content, part)
    part.replace(path)


def load(path: Path, agent: AsDDPG) -> int:
    """Give an agent the state in a checkpoint; returns the training step it was written at.

    Raises:
        UserError: the file is missing, not a checkpoint of this program, or of another network.
    """
    content = _read(path, FORMAT)
    with _fitting(path):
        agent.load_state(content["agent"])
        return int(content["step"])


def load_snapshot(path: Path, agent: AsDDPG) -> int:
    """Give an agent's networks the weights in a snapshot; returns the training step it was written at.

    Raises:
        UserError: as load.
    """
    content = _read(path, SNAPSHOT_FORMAT)
    with _fitting(path):
        agent.networks.load_state_dict(content["networks"])
        return int(content["step"])


@contextmanager
def _fitting(path: Path) -> Iterator[None]:
    try:
        yield
    except (KeyError, RuntimeError, ValueError, TypeError, AttributeError) as error:
        raise UserError(f"the checkpoint {path} does not fit the network that its run's config.yaml names") from error


def _read(path: Path, form: str) -> dict[str, Any]:
    if not path.is_file():
        raise UserError(f"there is no checkpoint {path}")
    try:
        check_packed(path, largest=path.stat().st_size)  # torch.save packs nothing
        content = torch.load(path, map_location="cpu", weights_only=True)
    except (BadZipFile, pickle.UnpicklingError, RuntimeError, EOFError, ValueError, KeyError, OSError) as error:
        raise UserError(f"{path} is damaged or not a checkpoint written by asddpg.train") from error
    if not isinstance(content, dict) or content.get("format") != form:
        raise UserError(f"{path} is not a checkpoint written by asddpg.train")
    return content
