"""The truth table of γ_p (section V): it scales the dense part, of the controller's steps, while that is positive."""

import numpy as np
import pytest

from asddpg.algorithm.reward_shaping import assisted_rewards
from asddpg.episodes.protocols import Driver
from tasks.rewards import REWARDS, Outcome, Reward, dense_part


def charged(reward: float, dense_reward: float, driver: Driver, gamma_p: float, price: float = 0.0) -> float:
    numbers = np.array([reward]), np.array([dense_reward]), np.array([driver is Driver.CONTROLLER])
    return float(assisted_rewards(*numbers, gamma_p, price)[0])


DENSE = Reward(progress=1.0, time_penalty=0.01, reach=5.0, crash=-5.0)


@pytest.mark.parametrize(
    ("driver", "outcome", "progress", "expected"),
    [
        (Driver.POLICY, Outcome.RUNNING, +0.09, 0.08),
        (Driver.POLICY, Outcome.RUNNING, -0.09, -0.10),
        (Driver.POLICY, Outcome.REACHED, +0.09, 5.0),
        (Driver.POLICY, Outcome.CRASHED, +0.09, -5.0),
        (Driver.POLICY, Outcome.TIMEOUT, +0.09, 0.08),
        (Driver.CONTROLLER, Outcome.RUNNING, +0.09, 0.04),
        (Driver.CONTROLLER, Outcome.RUNNING, +0.01, 0.0),
        (Driver.CONTROLLER, Outcome.RUNNING, -0.09, -0.10),
        (Driver.CONTROLLER, Outcome.REACHED, +0.09, 5.0),
        (Driver.CONTROLLER, Outcome.CRASHED, +0.09, -5.0),
        (Driver.CONTROLLER, Outcome.TIMEOUT, +0.09, 0.04),
    ],
)
def test_truth_table(driver: Driver, outcome: Outcome, progress: float, expected: float) -> None:
    terms = DENSE.terms(outcome, previous_distance=1.0, distance=1.0 - progress)
    reward = charged(sum(terms.values()), dense_part(terms), driver, gamma_p=0.5)
    np.testing.assert_allclose(reward, expected, atol=1e-12)


@pytest.mark.parametrize("outcome", [Outcome.RUNNING, Outcome.REACHED, Outcome.CRASHED, Outcome.TIMEOUT])
def test_never_acts_under_the_sparse_reward(outcome: Outcome) -> None:
    terms = REWARDS["sparse"].terms(outcome, previous_distance=1.0, distance=0.9)
    reward = sum(terms.values())
    assert charged(reward, dense_part(terms), Driver.CONTROLLER, gamma_p=0.0) == reward


def test_one_is_free() -> None:
    assert charged(0.08, 0.08, Driver.CONTROLLER, gamma_p=1.0) == 0.08


def test_a_price_is_taken_off_the_controllers_steps_under_any_reward() -> None:
    assert charged(-0.05, -0.05, Driver.CONTROLLER, gamma_p=0.5, price=0.1) == pytest.approx(-0.15)
    assert charged(0.08, 0.08, Driver.CONTROLLER, gamma_p=0.5, price=0.1) == pytest.approx(-0.06)
    assert charged(-0.05, -0.05, Driver.POLICY, gamma_p=0.5, price=0.1) == -0.05
