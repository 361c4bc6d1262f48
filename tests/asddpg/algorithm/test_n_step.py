"""n-step returns against sums written out by hand."""

import numpy as np
import pytest

from asddpg.algorithm.n_step import NStepReturns
from asddpg.algorithm.replay import BalancedReplay, ReplayShape, Transitions
from tests.support.one_agent import ROBOT, transitions


def steps(index: int, discount: float = 1.0, by_policy: float = 1.0, robots: int = 1) -> Transitions:
    """Step `index` of an episode of each robot: x is index, its reward index + 1, the switch's ten times that."""
    x, action = np.full(robots, index), np.tile(np.array([index, -index], np.float32), (robots, 1))
    return transitions(x, action, (index + 1.0, 10.0 * (index + 1.0), discount, by_policy), x + 1)


NO, YES = np.array([False]), np.array([True])


def test_one_step_changes_nothing() -> None:
    returns = NStepReturns(1, 0.9)
    given = [steps(0), steps(1, discount=0.0)]
    taken = [out for index, step in enumerate(given) for out in returns.add(step, YES if index else NO)]
    for before, after in zip(given, taken, strict=True):
        for one, other in zip(before, after, strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("last_discount", [0.0, 1.0], ids=["end", "time limit"])
def test_three_steps_and_what_is_left_at_the_end(last_discount: float) -> None:
    returns, gamma = NStepReturns(3, 0.9), 0.9
    taken = [
        out
        for index in range(4)
        for out in returns.add(steps(index, last_discount if index == 3 else 1.0), YES if index == 3 else NO)
    ]
    assert [int(out.observation[0]) for out in taken] == [0, 1, 2, 3]
    assert [int(out.next_observation[0]) for out in taken] == [3, 4, 4, 4]
    rewards = [1 + 0.9 * 2 + 0.81 * 3, 2 + 0.9 * 3 + 0.81 * 4, 3 + 0.9 * 4, 4]
    np.testing.assert_allclose([out.reward[0] for out in taken], rewards)
    np.testing.assert_allclose([out.switch_reward[0] for out in taken], 10 * np.array(rewards))
    discounts = [gamma**2, gamma**2 * last_discount, gamma * last_discount, last_discount]
    np.testing.assert_allclose([out.discount[0] for out in taken], discounts)


def test_episodes_are_not_joined_whether_ended_or_cut() -> None:
    returns = NStepReturns(3, 0.9)
    assert len(returns.add(steps(0), YES)) == 1
    assert returns.add(steps(5), NO) == []
    returns.begin_episodes(ROBOT)
    (only,) = returns.add(steps(7), YES)
    assert only.observation[0] == 7


def test_many_robots_have_the_returns_that_each_has_alone() -> None:
    rng = np.random.default_rng(0)
    ends = rng.random((50, 5)) < 0.2
    together, alone = NStepReturns(3, 0.9, robots=5), [NStepReturns(3, 0.9) for _ in range(5)]
    for index in range(50):
        step = steps(index, robots=5)._replace(reward=rng.normal(size=5), by_policy=np.arange(5.0))
        found: dict[int, list[tuple[float, ...]]] = {robot: [] for robot in range(5)}
        for out in together.add(step, ends[index]):
            for row in range(len(out.reward)):
                robot = int(out.by_policy[row])
                found[robot].append((out.observation[row], out.next_observation[row], out.reward[row]))
        for robot in range(5):
            own = alone[robot].add(step.of(np.arange(5) == robot), ends[index, robot : robot + 1])
            assert found[robot] == [(out.observation[0], out.next_observation[0], out.reward[0]) for out in own]


def fill(replay: BalancedReplay, index: int, by_policy: float) -> None:
    numbers = [replay.observe(np.full((1, 1), value, np.float32), ROBOT) for value in (index, index + 1)]
    replay.add(steps(index, by_policy=by_policy)._replace(observation=numbers[0], next_observation=numbers[1]))


def test_a_balanced_batch_is_half_from_each_driver() -> None:
    replay = BalancedReplay(ReplayShape(1000, 1, 2), np.random.default_rng(0))
    for index in range(100):
        fill(replay, index, by_policy=0.0)
    assert np.all(replay.sample(32)[:, replay.layout.by_policy] == 0.0)  # no step of the policy yet
    fill(replay, 100, by_policy=1.0)
    assert len(replay) == 101
    assert replay.sample(32)[:, replay.layout.by_policy].sum() == 16
