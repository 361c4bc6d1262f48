"""What does not fit into memory is refused before it is allocated."""

import os

import pytest

from asddpg.algorithm import memory_check
from asddpg.algorithm.networks import NetworkShape
from asddpg.algorithm.replay import TransitionLayout
from asddpg.command_line import train_config
from asddpg.errors import UserError

SHAPE = NetworkShape(4, None, [0.0, -1.0], [1.0, 1.0], [8])
RING = 4 * TransitionLayout.build(4, 2).width * 1_000_000  # bytes of a million transitions


def check(patch: pytest.MonkeyPatch, *arguments: str) -> None:
    """On a machine whose memory holds one ring of a million transitions, and not two."""
    patch.setattr(os, "sysconf", {"SC_PHYS_PAGES": 3 * RING // 2, "SC_PAGE_SIZE": 1}.__getitem__)
    memory_check.check_memory(SHAPE, train_config(["agent.buffer_size=1000000", *arguments]).agent)


def test_one_replay_buffer_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    check(monkeypatch)


def test_balanced_batches_need_two(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UserError, match=r"replay buffer takes .* lower agent\.buffer_size"):
        check(monkeypatch, "agent.balanced_batches=true")
