"""The discounted return, worked out by hand."""

import numpy as np
import pytest

from asddpg.config import LearningConfig, TrainConfig
from tasks import Reward
from tools.diagnosis.returns import MAX_UNKNOWN_WEIGHT, Tail, discounted_returns, tail_bounds

TAIL = Tail(worst=-8.0, best=4.0)


def test_after_an_end_nothing_follows() -> None:
    returns = discounted_returns(np.array([-1.0, -1.0, 10.0]), 0.5, True, TAIL)
    expected = [-1 + 0.5 * (-1 + 0.5 * 10), -1 + 0.5 * 10, 10]
    np.testing.assert_allclose(returns.low, expected)
    np.testing.assert_allclose(returns.high, expected)
    assert returns.is_counted.all()


def test_after_a_time_limit_the_worst_or_the_best_may_follow() -> None:
    returns = discounted_returns(np.array([-1.0, -1.0, -1.0]), 0.5, False, TAIL)
    np.testing.assert_allclose(returns.low, [-1.75 - 8 / 8, -1.5 - 8 / 4, -1 - 8 / 2])
    np.testing.assert_allclose(returns.high, [-1.75 + 4 / 8, -1.5 + 4 / 4, -1 + 4 / 2])
    # What is unknown weighs 1/8, 1/4 and 1/2.
    assert MAX_UNKNOWN_WEIGHT == 0.2
    assert returns.is_counted.tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("reward", "worst", "best"),
    [
        # Standing for ever costs 0.05 / (1 − 0.99) = 5, a crash 4 or 6; at best the goal comes at once.
        (Reward(progress=0.0, time_penalty=0.05, crash=-4.0, reach=3.0), -5.0, 3.0),
        (Reward(progress=0.0, time_penalty=0.05, crash=-6.0, reach=3.0), -6.0, 3.0),
        # 0.5 m/s · 0.2 s = 0.1 m a step nearer or farther, less 0.01, for ever.
        (Reward(progress=1.0, time_penalty=0.01, crash=-5.0, reach=5.0), -11.0, 9.0),
    ],
)
def test_the_rewards_bounds(reward: Reward, worst: float, best: float) -> None:
    tail = tail_bounds(TrainConfig(reward=reward))
    assert [tail.worst, tail.best] == pytest.approx([worst, best])


def test_the_controllers_price_may_follow_too() -> None:
    config = TrainConfig(reward=Reward(progress=0.0, time_penalty=0.05), agent=LearningConfig(controller_price=0.05))
    assert tail_bounds(config).worst == pytest.approx(-10.0)
