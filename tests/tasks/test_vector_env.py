"""The vector environment equals single environments to the last bit."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import tasks
from asddpg.runs import state_files
from tasks.errors import TaskError
from tasks.gymnasium_api.navigation_vector_env import NavigationVectorEnv
from tasks.laser import LaserConfig
from tasks.navigation import NavigationConfig

LASERS = {"perfect": LaserConfig(), "late": LaserConfig(noise=1.0, dropout=0.1, latency=0.47)}
LIMITS = {"max_episode_steps": 12}
ROOMS = ("nav_complex", "nav_gazebo", "nav_empty")


def make(task: Any = "nav_complex", num_envs: int = 3, laser: str = "perfect", **options: Any) -> NavigationVectorEnv:
    config = NavigationConfig(laser=LASERS[laser], time_limit_steps=25)
    return NavigationVectorEnv(task, num_envs, config=config, **options)


def commands(steps: int, num_envs: int = 3) -> Any:
    return np.random.default_rng(0).uniform([0.0, -1.0], [0.5, 1.0], (steps, num_envs, 2))


def assert_equal_info(info: dict[str, Any], other: dict[str, Any]) -> None:
    """Gymnasium makes arrays of objects of what is no number, and leaves other rows as they were."""
    assert set(info) == set(other)
    for key in [key for key in info if not key.startswith("_")]:
        mask = info[f"_{key}"]
        np.testing.assert_equal(mask, other[f"_{key}"])
        if isinstance(info[key], dict):
            assert_equal_info(info[key], other[key])
        else:
            assert [np.array(each).tolist() for each in info[key][mask]] == [
                np.array(each).tolist() for each in other[key][mask]
            ], key


@pytest.mark.parametrize("laser", LASERS)
@pytest.mark.parametrize("mode", AutoresetMode)
def test_robots_equal_single_environments_to_the_last_bit(mode: AutoresetMode, laser: str) -> None:
    config = NavigationConfig(laser=LASERS[laser], time_limit_steps=25)
    limit: Any = LIMITS if laser == "late" else {}  # Gymnasium's TimeLimit around the single ones
    ours = make(ROOMS, laser=laser, autoreset_mode=mode, **limit)
    singles = [lambda room=room: gymnasium.make(tasks.gymnasium_id(room), config=config, **limit) for room in ROOMS]
    theirs = SyncVectorEnv(singles, autoreset_mode=mode)
    begun, expected = ours.reset(seed=7), theirs.reset(seed=7)
    np.testing.assert_equal(begun[0], expected[0])
    assert_equal_info(begun[1], expected[1])
    for actions in commands(60):
        ended = ours.step(actions), theirs.step(actions)
        for ours_, theirs_ in zip(ended[0][:4], ended[1][:4], strict=True):
            np.testing.assert_equal(ours_, theirs_)
        assert_equal_info(ended[0][4], ended[1][4])
        over = ended[0][2] | ended[0][3]
        if mode == AutoresetMode.DISABLED and over.any():
            again = [env.reset(options={"reset_mask": over.copy()})[0] for env in (ours, theirs)]
            np.testing.assert_equal(again[0], again[1])
    ours.close()
    theirs.close()


def test_robots_in_rooms_of_their_own_equal_single_environments() -> None:
    config = {"variation": {"noise": 1.0, "latency": 0.3, "friction": 0.3, "mass": 0.3}, "time_limit_steps": 25}
    config |= {"goal_range": 2.0}
    reward = {"turn_price": 0.1}
    ours = NavigationVectorEnv("nav_anywhere", 3, config=config, reward=reward)
    single = [lambda: gymnasium.make("asddpg/NavAnywhere-v0", config=config, reward=reward)] * 3
    theirs = SyncVectorEnv(single)
    assert_equal_info(ours.reset(seed=7)[1], theirs.reset(seed=7)[1])
    rooms = set()
    for actions in commands(60):
        ended = ours.step(actions), theirs.step(actions)
        for ours_, theirs_ in zip(ended[0][:4], ended[1][:4], strict=True):
            np.testing.assert_equal(ours_, theirs_)
        assert_equal_info(ended[0][4], ended[1][4])
        rooms |= set(ended[0][4]["room"])
    assert len(rooms) > 6
    theirs.close()


def test_a_restored_vector_goes_on_equal_to_the_last_bit(tmp_path: Any) -> None:
    vector, other = make(laser="late"), make(laser="late")
    vector.reset(seed=1)
    for actions in commands(40):
        vector.step(actions)
    state_files.write(tmp_path, vector.state())
    other.load_state(state_files.read(tmp_path))
    for actions in commands(40):
        np.testing.assert_equal(other.step(actions), vector.step(actions))


def test_a_single_environment_continues_a_robot_of_a_vector() -> None:
    vector, single = make(num_envs=2), gymnasium.make("asddpg/NavComplex-v0", config={"time_limit_steps": 25})
    vector.reset(seed=1)
    for actions in commands(12, 2):
        vector.step(actions)
    single.unwrapped.load_state(vector.state()["envs"][1])  # type: ignore[attr-defined]
    for actions in commands(5, 2):
        np.testing.assert_equal(single.step(actions[1])[:2], [each[1] for each in vector.step(actions)[:2]])


def test_make_vec_gives_robots_that_begin_differently_without_a_seed() -> None:
    vector: Any = gymnasium.make_vec("asddpg/NavComplex-v0", num_envs=4)
    assert isinstance(vector, NavigationVectorEnv)
    assert len(np.unique(vector.reset()[1]["goal"], axis=0)) == 4


def test_what_robots_cannot_do_is_refused() -> None:
    for option in ("num_envs", "num_threads", "max_episode_steps"):
        with pytest.raises(TaskError, match=f"{option} must be greater than 0, not 0"):
            make(**{option: 0})  # type: ignore[arg-type]
    with pytest.raises(TaskError, match="not 2"):
        make(task=("nav_empty", "nav_empty"))
    vector = make(autoreset_mode=AutoresetMode.DISABLED)
    with pytest.raises(gymnasium.error.ResetNeeded):
        vector.step(np.zeros((3, 2)))
    with pytest.raises(TaskError, match="one of them true"):
        vector.reset(options={"reset_mask": np.zeros(3, bool)})
    with pytest.raises(TaskError, match="must lie in the room"):
        vector.reset(options={"goal": (40.0, 0.0)})
    vector.reset()
    with pytest.raises(TaskError, match="for each of 3"):
        vector.step(np.zeros((2, 2)))
