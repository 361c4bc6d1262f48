"""The figures of an evaluation, on episodes whose figures are known."""

import numpy as np
import pytest
from scipy import stats

from asddpg.build import make_environment
from asddpg.command_line import train_config
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.evaluation import evaluate, summarize_episodes
from asddpg.episodes.intervals import mean, rate
from asddpg.episodes.protocols import Decision, Driver, Episode, Observation
from tasks import ALL_TASKS
from tasks.evaluation_pairs import stored_pairs
from tasks.registry import find_task
from tasks.rewards import REWARDS
from tasks.room_geometry.held_out import held_out_pairs

EPISODES = [
    Episode("reached", steps=50, total_reward=4.0, controller_steps=10, path_length=4.0),
    Episode("reached", steps=100, total_reward=4.0, controller_steps=0, path_length=2.0),
    Episode("crashed", steps=30, total_reward=-5.0, controller_steps=30, path_length=1.0),
    Episode("timeout", steps=200, total_reward=-1.0, controller_steps=0, path_length=9.0),
]


def test_figures_of_known_episodes() -> None:
    result = summarize_episodes(EPISODES, shortest_paths=[2.0, 2.5, 1.0, 3.0], control_timestep=0.2)
    assert (result.success_rate.value, result.collision_rate.value, result.timeout_rate.value) == (0.5, 0.25, 0.25)
    assert result.metric.value == pytest.approx((2 - 0.5 + 2 - 1.0 - 0.3 - 2.0) / 4)
    assert result.mean_time.value == pytest.approx((10.0 + 20.0) / 2)
    # The second drove less than the grid's shortest path, which counts as no detour.
    assert result.spl.value == pytest.approx((2.0 / 4.0 + 1.0) / 4)
    assert result.controller_share == pytest.approx(40 / 380)
    for lengths in ([1.0, 1.0, 1.0], [9.0, 9.0, 1.0]):  # near 0 and near 1
        few = summarize_episodes([EPISODES[0], EPISODES[1], EPISODES[2]], lengths, control_timestep=0.2)
        assert few.spl.low is not None
        assert few.spl.high is not None
        assert 0.0 <= few.spl.low <= few.spl.high <= 1.0
        assert few.mean_time.low == 0.0
        assert few.metric.high == 2.0
    failed = summarize_episodes(EPISODES[2:], shortest_paths=[1.0, 3.0], control_timestep=0.2)
    assert (failed.mean_time.value, failed.spl.value) == (None, 0.0)


def test_a_noisy_laser_gives_the_same_figures_twice() -> None:
    config = train_config(["task=nav_simple", "task.laser.noise=3", "task.time_limit_steps=30"])
    seen: list[list[Observation]] = []

    def by_scan(observation: Observation) -> Decision:
        seen[-1].append(observation.copy())
        return Decision(np.array([0.3, observation[0]], dtype=np.float32), Driver.POLICY)

    for _ in range(2):
        seen.append([])
        environment = make_environment(config.task, config.reward)
        evaluate(environment, FixedDriver(by_scan), held_out_pairs("nav_simple", "test")[:2], 0.2)
    np.testing.assert_array_equal(seen[0], seen[1])


def test_intervals_are_wilsons_and_students() -> None:
    # 8 of 10: the textbook's example of Wilson's interval.
    assert rate(8, 10) == pytest.approx((0.8, 0.490, 0.943), abs=5e-4)
    assert rate(0, 200).low == 0.0
    values = [0.8, 0.9, 1.0]
    half = stats.t.ppf(0.975, 2) * np.std(values, ddof=1) / np.sqrt(3)
    assert mean(values) == pytest.approx((0.9, 0.9 - half, 0.9 + half))
    assert mean([1.0]) == (1.0, None, None)


def test_another_goal_radius_shortens_the_shortest_paths() -> None:
    pairs, wider = held_out_pairs("nav_empty", "test"), stored_pairs("nav_empty", "test", 0.8)
    assert [pair.goal for pair in pairs] == [pair.goal for pair in wider]
    gained = np.array([pair.shortest_path for pair in pairs]) - [pair.shortest_path for pair in wider]
    np.testing.assert_allclose(gained, 0.5, atol=0.12)


def test_a_training_earns_the_rewards_of_the_tasks() -> None:
    for name in ALL_TASKS:
        assert train_config([f"task={name}"]).reward == REWARDS[find_task(name).reward]
    for name, reward in REWARDS.items():
        assert train_config([f"reward={name}"]).reward == reward
