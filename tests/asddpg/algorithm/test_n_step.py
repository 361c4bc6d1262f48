"""n-step returns against sums written out by hand."""

import numpy as np
import pytest

from asddpg.algorithm.n_step import NStepReturns
from asddpg.algorithm.replay import BalancedReplay, Transition


def transition(index: int, discount: float = 1.0, by_policy: float = 1.0) -> Transition:
    """Step `index` of an episode: x is [index], its reward index + 1, the switch's ten times that."""
    x, x_next = np.array([index], np.float32), np.array([index + 1], np.float32)
    action = np.array([index, -index], np.float32)
    return Transition(x, action, index + 1.0, 10.0 * (index + 1.0), discount, by_policy, x_next, action)


def test_one_step_changes_nothing() -> None:
    returns = NStepReturns(1, 0.9)
    given = [transition(0), transition(1, discount=0.0)]
    taken = [out for index, step in enumerate(given) for out in returns.add(step, index == 1)]
    for before, after in zip(given, taken, strict=True):
        assert after.reward == before.reward
        assert after.discount == before.discount
        np.testing.assert_array_equal(after.next_observation, before.next_observation)


@pytest.mark.parametrize("last_discount", [0.0, 1.0], ids=["end", "time limit"])
def test_three_steps_and_what_is_left_at_the_end(last_discount: float) -> None:
    returns, gamma = NStepReturns(3, 0.9), 0.9
    taken = [
        out
        for index in range(4)
        for out in returns.add(transition(index, last_discount if index == 3 else 1.0), index == 3)
    ]
    assert [int(out.observation[0]) for out in taken] == [0, 1, 2, 3]
    assert [int(out.next_observation[0]) for out in taken] == [3, 4, 4, 4]
    rewards = [1 + 0.9 * 2 + 0.81 * 3, 2 + 0.9 * 3 + 0.81 * 4, 3 + 0.9 * 4, 4]
    np.testing.assert_allclose([out.reward for out in taken], rewards)
    np.testing.assert_allclose([out.switch_reward for out in taken], 10 * np.array(rewards))
    discounts = [gamma**2, gamma**2 * last_discount, gamma * last_discount, last_discount]
    np.testing.assert_allclose([out.discount for out in taken], discounts)


def test_episodes_are_not_joined_whether_ended_or_cut() -> None:
    returns = NStepReturns(3, 0.9)
    assert len(returns.add(transition(0), is_last=True)) == 1
    assert returns.add(transition(5), is_last=False) == []
    returns.begin_episode()
    (only,) = returns.add(transition(7), is_last=True)
    assert only.observation[0] == 7.0


def test_a_balanced_batch_is_half_from_each_driver() -> None:
    replay = BalancedReplay(1000, 1, 2, np.random.default_rng(0))
    for index in range(100):
        replay.add(transition(index, by_policy=0.0))
    assert np.all(replay.sample(32)[:, replay.layout.by_policy] == 0.0)  # no step of the policy yet
    replay.add(transition(100))
    assert len(replay) == 101
    assert replay.sample(32)[:, replay.layout.by_policy].sum() == 16


def test_one_drivers_steps_push_out_none_of_the_others() -> None:
    replay = BalancedReplay(10, 1, 2, np.random.default_rng(0))
    replay.add(transition(0, by_policy=0.0))
    for index in range(100):
        replay.add(transition(index))
    assert len(replay) == 11
    rows = replay.sample(64)
    policys = rows[:, replay.layout.by_policy] == 1.0
    assert np.all(rows[~policys, 0] == 0.0)
    assert np.all(rows[policys, 0] >= 90.0)
