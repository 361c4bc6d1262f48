"""What does not fit into memory is refused before it is allocated."""

import os

import pytest

from asddpg.algorithm import memory_check
from asddpg.algorithm.networks import NetworkShape
from asddpg.algorithm.replay import ReplayShape
from asddpg.command_line import train_config
from asddpg.errors import UserError

SHAPE = NetworkShape(2050, (3, 682), [0.0, -1.0], [1.0, 1.0], [8])
REPLAY = ReplayShape(1_000_000, 2050, 2, (3, 682), n_steps=3)


def test_a_replay_buffer_needs_memory_for_each_scan_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a machine whose memory holds a million scans of 682 beams and the rest of as many transitions."""
    monkeypatch.setattr(os, "sysconf", {"SC_PHYS_PAGES": 4 * 900_000_000, "SC_PAGE_SIZE": 1}.__getitem__)
    config = train_config(["agent.buffer_size=1000000"]).agent
    memory_check.check_memory(SHAPE, config, REPLAY)
    with pytest.raises(UserError, match=r"replay buffer takes .* lower agent\.buffer_size"):
        memory_check.check_memory(SHAPE, config, replace_stack(REPLAY))


def replace_stack(shape: ReplayShape) -> ReplayShape:
    """The same without a stack, whose observations are kept whole."""
    return shape._replace(scan_shape=None)
