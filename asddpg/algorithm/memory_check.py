"""Checks before allocation that an agent fits into memory and matches the size of its weights' file."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from asddpg.algorithm.networks import NetworkShape, branch_size
from asddpg.algorithm.replay import ReplayShape
from asddpg.errors import UserError

if TYPE_CHECKING:  # asddpg.config imports tasks, and with it mujoco, which an agent does without
    from asddpg.config import AgentConfig

_BYTES = 4  # of a float32
# Networks and targets, each flat, and once more while it is flattened; their gradients and Adam's two moments.
_COPIES = 8
_HARMLESS = 2**26  # bytes; a smaller network is loaded, and loading reports what is wrong


def check_memory(shape: NetworkShape, learning: "AgentConfig", replay: ReplayShape) -> None:
    """UserError where weights or replay buffer are larger than this machine's memory."""
    branches = 2 + learning.assisted + learning.twin_critics
    _check(_COPIES * branches * branch_size(shape), "the networks take", "narrow network.widths")
    _check(replay.numbers, "the replay buffer takes", "lower agent.buffer_size")


def _check(numbers: int, what: str, cure: str) -> None:
    needed, memory = _BYTES * numbers, os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if needed > memory:
        raise UserError(f"{what} {needed / 1e9:.0f} GB of memory, and this machine has {memory / 1e9:.0f} GB: {cure}")


def check_file(path: Path, shape: NetworkShape) -> None:
    """UserError where a file of weights is too short for a large network that an untrusted config describes."""
    needed = _BYTES * branch_size(shape)
    if needed > _HARMLESS and path.is_file() and path.stat().st_size < needed:
        raise UserError(f"the weights in {path} are fewer than the network has that its run's config.yaml names")
