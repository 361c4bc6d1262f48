"""Figures of episodes and of a training, on cases that can be counted by hand."""

import json
from pathlib import Path

import numpy as np
import pytest

from asddpg.config import TaskConfig
from tools.diagnosis import as_json
from tools.driving_figures import End, driven, judged
from tools.returns import Tail
from tools.rollouts import Rollout
from tools.training_figures import shares_by_distance, shares_by_place, windows_of

FULL = np.pi / 3


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


def test_actions_are_told_apart() -> None:
    actions = [(0.5, 0.0), (0.0, 0.0), (0.0, FULL), (0.25, -FULL)]
    figures = driven([rollout("reached", actions), rollout("crashed", actions)], TaskConfig())
    assert figures.saturated_v == 0.75
    assert figures.saturated_omega == 0.5
    assert figures.standing == 0.25
    assert figures.circling == 0.25
    assert figures.controller_share == 0.5
    assert figures.nowhere is None  # no episode lasts 5 s
    assert figures.ends[1] == End("crashed", 0.0, 0.0, 5.0)
    assert (figures.reach_rate.value, figures.crash_rate.value, figures.timeout_rate.value) == (0.5, 0.5, 0.0)


def test_who_circles_slowly_gets_nowhere_too() -> None:
    angles = np.arange(51) * 0.2
    circle = np.stack([0.1 * np.cos(angles), 0.1 * np.sin(angles)], axis=1)
    straight = np.stack([np.arange(51) * 0.1, np.zeros(51)], axis=1)
    both = [rollout("timeout", [(0.1, 1.0)] * 50, list(map(tuple, way.tolist()))) for way in (circle, straight)]
    assert driven(both[:1], TaskConfig()).nowhere == 1.0
    assert driven(both, TaskConfig()).nowhere == 0.5
    assert driven(both[:1], TaskConfig()).circling == 0.0


def test_q_is_held_against_what_followed() -> None:
    three_steps = rollout("reached", [(0.5, 0.0)] * 3)
    found = judged(np.array([2.75, 1.5, 1.0]), [three_steps], 0.5, Tail(-8.0, 8.0))
    assert found.bias == pytest.approx((2.75 - 1.75) / 3)
    assert found.bias_low == found.bias_high == found.bias
    assert (found.states, found.left_out) == (3, 0)


def test_the_time_limit_makes_an_interval_of_the_bias() -> None:
    broken_off = rollout("timeout", [(0.5, 0.0)] * 3)
    found = judged(np.array([1.75, 100.0, 100.0]), [broken_off], 0.5, Tail(-8.0, 8.0))
    assert (found.states, found.left_out) == (1, 2)
    assert (found.bias_low, found.bias, found.bias_high) == (-1.0, 0.0, 1.0)
    nothing = judged(np.array([1.0]), [rollout("timeout", [(0.5, 0.0)])], 0.5, Tail(-8.0, 8.0))
    assert (nothing.states, nothing.bias, nothing.bins) == (0, None, [])


def test_a_critic_that_diverged_can_still_be_written() -> None:
    found = as_json(judged(np.array([np.nan, np.inf]), [rollout("reached", [(0.5, 0.0)] * 2)], 0.5, Tail(-8.0, 8.0)))
    assert found["mean_q"] is found["bias"] is None
    assert found["mean_return"] == 1.25
    json.dumps(found, allow_nan=False)


def test_windows_of_training(tmp_path: Path) -> None:
    path = tmp_path / "metrics.csv"
    shares, errors = [1, 1, 1, 1, 1, 0, 0, 0, 0, 0], ["1", "2", "3", "4", "", "", "", "", "", ""]
    rows = [f"{10 * n},10,{share},{error}" for n, share, error in zip(range(1, 11), shares, errors, strict=True)]
    path.write_text("\n".join(["step,steps,controller_share,td_error_policy", *rows]) + "\n")
    windows = windows_of(path)
    assert windows.steps == [25.0, 75.0]
    assert windows.shares == [1.0, 0.0]
    assert windows.td_policy == [2.5, None]
    assert windows.td_controller == [None, None]  # a column that older runs have not


def test_shares_by_distance_and_place() -> None:
    count = 400
    steps = {
        "x": np.where(np.arange(count) % 2, 0.1, -0.1),
        "y": np.zeros(count),
        "distance": np.where(np.arange(count) % 2, 0.7, 2.2),
        "by_controller": np.where(np.arange(count) % 2, 1.0, 0.0),
    }
    as_logged = {name: values.astype(np.float32) for name, values in steps.items()}
    quarters = shares_by_distance(as_logged)
    assert [quarter.distances for quarter in quarters] == [[0.75, 2.25]] * 4
    assert [quarter.shares for quarter in quarters] == [[1.0, 0.0]] * 4
    cells = {(cell.x, cell.y): (cell.steps, cell.share) for cell in shares_by_place(as_logged)}
    assert cells == {(-0.2, 0.2): (50, 0.0), (0.2, 0.2): (50, 1.0)}
