"""The replay buffer gives back what robots observed, though it keeps each scan once."""

from typing import Any

import numpy as np
import pytest

from asddpg.algorithm.n_step import NStepReturns
from asddpg.algorithm.observation_ring import ObservationRing
from asddpg.algorithm.replay import ReplayBuffer, ReplayShape, Transitions
from tests.support.one_agent import ROBOT

SCANS, BEAMS, REST = 3, 5, 2
SIZE = SCANS * BEAMS + REST


class Robots:
    """Stacks of random scans that robots see; an episode begins with one scan throughout."""

    def __init__(self, count: int, seed: int = 0) -> None:
        self.rng = np.random.default_rng(seed)
        self.stacks = np.zeros((count, SCANS, BEAMS), np.float32)

    def begin(self, robots: Any) -> Any:
        self.stacks[robots] = self.rng.random((len(robots), 1, BEAMS), np.float32)
        return self.observe()[robots]

    def step(self) -> Any:
        newest = self.rng.random((len(self.stacks), 1, BEAMS), np.float32)
        self.stacks = np.concatenate([newest, self.stacks[:, :-1]], axis=1)
        return self.observe()

    def observe(self) -> Any:
        rest = self.rng.random((len(self.stacks), REST), np.float32)
        return np.concatenate([self.stacks.reshape(len(self.stacks), -1), rest], axis=1)


@pytest.mark.parametrize(("count", "n", "capacity", "end"), [(4, 3, 60, 0.1), (1, 1, 20, 0.05), (3, 5, 400, 0.7)])
def test_every_sample_is_a_step_that_was_made(count: int, n: int, capacity: int, end: float) -> None:
    """Also where the rings have wrapped several times, and where episodes are too short for the buffer to be full."""
    rng, robots, everyone = np.random.default_rng(1), Robots(count), np.arange(count)
    shape = ReplayShape(capacity, SIZE, 1, (SCANS, BEAMS), n, count)
    replay, returns = ReplayBuffer(shape, np.random.default_rng(2)), NStepReturns(n, 1.0, count)
    x = robots.begin(everyone)
    present = replay.observe(x, everyone)
    by_number = dict(zip(present.tolist(), x, strict=True))
    for step in range(200):
        over = rng.random(count) < end
        x_next = robots.step()
        numbers = replay.observe(x_next, everyone)
        by_number |= dict(zip(numbers.tolist(), x_next, strict=True))
        action, zeros = np.full((count, 1), step, np.float32), np.zeros(count)
        steps = Transitions(present, action, zeros, zeros, zeros, zeros, numbers, action)
        for completed in returns.add(steps, over):
            named = [numbers.astype(float) for numbers in (completed.observation, completed.next_observation)]
            replay.add(completed._replace(reward=named[0], switch_reward=named[1]))
        present = numbers.copy()
        if over.any():
            ended = np.flatnonzero(over)
            begun = robots.begin(ended)
            present[ended] = replay.observe(begun, ended)
            by_number |= dict(zip(present[ended].tolist(), begun, strict=True))
        if len(replay):
            rows, layout = replay._packed(np.arange(replay._begin, replay._end, 1 + step % 7)), replay.layout
            for row in rows:
                np.testing.assert_array_equal(row[layout.observation], by_number[int(row[layout.reward])])
                np.testing.assert_array_equal(row[layout.next_observation], by_number[int(row[layout.switch_reward])])
    assert len(replay) == capacity if end < 0.5 else 0 < len(replay) < capacity


def test_a_scan_is_kept_once() -> None:
    ring = ObservationRing(1000, 3 * 682 + 4, (3, 682), robots=1)
    held = sum(values.nbytes for values in vars(ring).values() if isinstance(values, np.ndarray))
    assert held < 1.05 * 1000 * 682 * 4


def test_a_stack_that_does_not_go_on_is_refused() -> None:
    ring, robots = ObservationRing(10, SIZE, (SCANS, BEAMS), robots=1), Robots(1)
    ring.add(robots.begin(ROBOT), ROBOT)
    robots.step()
    with pytest.raises(ValueError, match="those before it, moved by one"):
        ring.add(robots.step(), ROBOT)
