"""What does not fit into memory is refused before it is allocated."""

import os
from dataclasses import replace

import pytest

from asddpg.algorithm import memory_check
from asddpg.algorithm.networks import NetworkShape
from asddpg.algorithm.replay import TransitionLayout
from asddpg.command_line import train_config
from asddpg.errors import UserError

SHAPE = NetworkShape(4, None, [0.0, -1.0], [1.0, 1.0], [8])
RING = 4 * TransitionLayout.build(4, 2).width * 1_000_000  # bytes of a million transitions


def test_balanced_batches_need_memory_for_two_rings(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a machine whose memory holds one ring of a million transitions, and not two."""
    monkeypatch.setattr(os, "sysconf", {"SC_PHYS_PAGES": 3 * RING // 2, "SC_PAGE_SIZE": 1}.__getitem__)
    config = train_config(["agent.buffer_size=1000000"]).agent
    memory_check.check_memory(SHAPE, config)
    with pytest.raises(UserError, match=r"replay buffer takes .* lower agent\.buffer_size"):
        memory_check.check_memory(SHAPE, replace(config, balanced_batches=True))
