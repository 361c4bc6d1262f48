"""Metrics of episodes and of a training, on cases that can be counted by hand."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asddpg.config import AgentConfig, TaskConfig, TrainConfig
from asddpg.errors import UserError
from tasks import Reward
from tools.diagnosis.drive_metrics import End, drive_metrics, q_calibration
from tools.diagnosis.returns import MAX_UNKNOWN_WEIGHT, Tail, discounted_returns, tail_bounds
from tools.diagnosis.rollouts import Rollout
from tools.diagnosis.run_diagnosis import to_json
from tools.diagnosis.step_metrics import (
    read_steps,
    shares_by_distance,
    shares_by_place,
    shares_over_training,
)
from tools.diagnosis.training_metrics import read_training_metrics, read_windows

FULL = np.pi / 3


TAIL = Tail(worst=-8.0, best=4.0)


def rollout(
    outcome: str, actions: list[tuple[float, float]], places: list[tuple[float, float]] | None = None
) -> Rollout:
    count = len(actions)
    return Rollout(
        outcome=outcome,
        goal=(3.0, 4.0),
        places=np.array(places if places else [(0.0, 0.0)] * (count + 1)),
        observations=np.zeros((count, 124), dtype=np.float32),
        actions=np.array(actions),
        by_controller=np.arange(count) % 2 == 0,
        rewards=np.ones(count),
    )


def test_metrics_of_actions() -> None:
    actions = [(0.5, 0.0), (0.0, 0.0), (0.0, FULL), (0.25, -FULL)]
    metrics = drive_metrics([rollout("reached", actions), rollout("crashed", actions)], TaskConfig())
    assert (metrics.saturated_v, metrics.saturated_omega, metrics.standing, metrics.circling) == (0.75, 0.5, 0.25, 0.25)
    assert metrics.controller_share == 0.5
    assert metrics.stuck is None  # no episode lasts 5 s
    assert metrics.ends[1] == End("crashed", 0.0, 0.0, 5.0)
    assert (metrics.success_rate.value, metrics.collision_rate.value, metrics.timeout_rate.value) == (0.5, 0.5, 0.0)
    slow = [rollout("timeout", [(0.05, 0.0), (0.08, 0.0), (0.09, FULL), (0.12, FULL)])]
    for least, shares in ((0.05, (0.25, 0.25)), (0.0, (0.0, 0.0))):
        found = drive_metrics(slow, TaskConfig(min_linear_velocity=least))
        assert (found.standing, found.circling) == shares


def test_a_robot_that_circles_slowly_is_stuck() -> None:
    angles = np.arange(51) * 0.2
    circle = np.stack([0.1 * np.cos(angles), 0.1 * np.sin(angles)], axis=1)
    straight = np.stack([np.arange(51) * 0.1, np.zeros(51)], axis=1)
    both = [rollout("timeout", [(0.1, 1.0)] * 50, list(map(tuple, way.tolist()))) for way in (circle, straight)]
    assert drive_metrics(both[:1], TaskConfig()).stuck == 1.0
    assert drive_metrics(both, TaskConfig()).stuck == 0.5
    assert drive_metrics(both[:1], TaskConfig()).circling == 0.0


def test_q_is_compared_with_the_return() -> None:
    """The time limit makes an interval of the bias."""
    three_steps = rollout("reached", [(0.5, 0.0)] * 3)
    found = q_calibration(np.array([2.75, 1.5, 1.0]), [three_steps], 0.5, TAIL)
    assert found.bias == pytest.approx((2.75 - 1.75) / 3)
    assert found.bias_low == found.bias_high == found.bias
    assert (found.states, found.excluded) == (3, 0)
    found = q_calibration(np.array([1.75, 100.0, 100.0]), [rollout("timeout", [(0.5, 0.0)] * 3)], 0.5, TAIL)
    assert (found.states, found.excluded) == (1, 2)
    assert (found.bias_low, found.bias, found.bias_high) == (-0.5, 0.25, 1.0)
    nothing = q_calibration(np.array([1.0]), [rollout("timeout", [(0.5, 0.0)])], 0.5, TAIL)
    assert (nothing.states, nothing.bias, nothing.bins) == (0, None, [])


def test_a_critic_that_diverged_can_still_be_written() -> None:
    two_steps = rollout("reached", [(0.5, 0.0)] * 2)
    found = to_json(q_calibration(np.array([np.nan, np.inf]), [two_steps], 0.5, TAIL))
    assert found["mean_q"] is found["bias"] is None
    assert found["mean_return"] == 1.25
    json.dumps(found, allow_nan=False)


@pytest.mark.parametrize("unfinished", ["", "110", "110,10", "110,10,0.5,0.2"])  # a row that is just being written
def test_windows_of_training(unfinished: str, tmp_path: Path) -> None:
    path = tmp_path / "metrics.csv"
    shares, errors = [1, 1, 1, 1, 1, 0, 0, 0, 0, 0], ["1", "2", "3", "4", "", "", "", "", "", ""]
    rows = [f"{10 * n},10,{share},{error}" for n, share, error in zip(range(1, 11), shares, errors, strict=True)]
    header = "step,steps,controller_share,td_error_policy"
    path.write_text("\r\n".join([header, *rows, unfinished]), newline="")
    windows = read_windows(path)
    assert windows.steps == [25.0, 75.0]
    assert windows.driven == [1.0, 0.0]
    assert windows.td_policy == [2.5, None]
    assert windows.td_controller == [None, None]  # a column that older runs have not


@pytest.mark.parametrize("content", ["step,steps\n1\n", "step,steps\n1,one\n", "step,steps\nnan,1\n", "other\n1\n"])
def test_damaged_metrics_are_one_sentence(content: str, tmp_path: Path) -> None:
    path = tmp_path / "metrics.csv"
    path.write_text(content)
    with pytest.raises(UserError, match=r"metrics\.csv is damaged"):
        read_windows(path)
    path.unlink()
    with pytest.raises(UserError, match=r"metrics\.csv cannot be read: No such file"):
        read_windows(path)


@pytest.fixture
def step_log(tmp_path: Path) -> Path:
    """Near the goal the switch prefers the controller, which drives in the first half alone."""
    count = 400
    near = np.arange(count) % 2 == 1
    steps = {
        "x": np.where(near, 0.1, -0.1),
        "y": np.zeros(count),
        "distance": np.where(near, 0.7, 2.2),
        "by_controller": near & (np.arange(count) < count / 2),
        "q_policy": np.where(near, -1.0, 1.0),
        "q_controller": np.zeros(count),
    }
    path = tmp_path / "steps.npz"
    arrays: dict[str, Any] = {name: values.astype(np.float32) for name, values in steps.items()}
    np.savez_compressed(path, **arrays)
    return path


def test_shares_of_the_controller(step_log: Path) -> None:
    steps = read_steps(step_log)
    quarters = shares_by_distance(steps)
    assert [quarter.distances for quarter in quarters] == [[0.75, 2.25]] * 4
    assert [quarter.driven for quarter in quarters] == [[1.0, 0.0]] * 2 + [[0.0, 0.0]] * 2
    assert [quarter.preferred for quarter in quarters] == [[1.0, 0.0]] * 4
    cells = {(cell.x, cell.y): (cell.steps, cell.driven, cell.preferred) for cell in shares_by_place(steps)}
    assert cells == {(-0.2, 0.2): (50, 0.0, 0.0), (0.2, 0.2): (50, 0.0, 1.0)}
    found = shares_over_training(steps)
    assert (found.shares, found.steps[:2]) == ([0.5] * 40, [5.0, 15.0])


def test_a_damaged_step_log_is_one_sentence(step_log: Path) -> None:
    whole, steps = step_log.read_bytes(), dict(read_steps(step_log))
    for damaged in (b"", b"no archive", whole[:-40], whole[:200] + bytes(100) + whole[300:]):
        step_log.write_bytes(damaged)
        with pytest.raises(UserError, match=r"steps\.npz is damaged"):
            read_steps(step_log)
    for wrong in ({"x": np.zeros(3)}, {**steps, "x": np.zeros(3)}):
        np.savez(step_log, **wrong)
        with pytest.raises(UserError, match=r"steps\.npz is damaged"):
            read_steps(step_log)


def test_a_training_that_has_hardly_begun_has_no_metrics(step_log: Path, tmp_path: Path) -> None:
    (tmp_path / "metrics.csv").write_text("step,steps,controller_share\r\n18,1", newline="")
    nothing: dict[str, Any] = {name: values[:0] for name, values in read_steps(step_log).items()}
    np.savez(step_log, **nothing)
    found = read_training_metrics(tmp_path / "metrics.csv", step_log)
    assert found.windows.driven == [None]
    assert (found.preferred.steps, found.by_place) == ([], [])


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
    config = TrainConfig(reward=Reward(progress=0.0, time_penalty=0.05), agent=AgentConfig(controller_price=0.05))
    assert tail_bounds(config).worst == pytest.approx(-10.0)
