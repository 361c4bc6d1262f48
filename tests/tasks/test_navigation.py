"""Rewards, ends and options of the task, through Gymnasium."""

import math
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest

import tasks
from asddpg.command_line import train_config
from asddpg.errors import UserError
from tasks import LaserConfig, NavigationConfig, Reward
from tasks.errors import TaskError
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.physics import Pose
from tasks.rewards import REWARDS, Outcome


def make(name: str = "nav_empty", **options: Any) -> Any:
    return gymnasium.make(tasks.gymnasium_id(name), **options)


def drive(environment: Any, action: tuple[float, float], goal: tuple[float, float], steps: int = 300) -> list[Any]:
    environment.reset(options={"goal": goal})
    results = []
    for _ in range(steps):
        results.append(environment.step(np.array(action)))
        if results[-1][2] or results[-1][3]:
            break
    return results


@pytest.mark.parametrize(
    ("goal", "outcome", "expected"), [((2.5, 0.0), "reached", 5.0), ((-3.0, -3.0), "crashed", -5.0)]
)
def test_reaching_and_crashing_end_the_episode_with_their_rewards(
    goal: tuple[float, float], outcome: str, expected: float
) -> None:
    results = drive(make(), (0.5, 0.0), goal)
    _, reward, terminated, truncated, info = results[-1]
    assert (terminated, truncated, info["outcome"], reward) == (True, False, outcome, expected)
    if outcome == "reached":
        assert info["distance"] <= 0.3
        # 2.2 m at 0.5 m/s are 22 steps of 0.2 s, one or two more for getting going.
        assert 22 <= len(results) <= 24


def test_two_hundred_steps_truncate_the_episode() -> None:
    results = drive(make(), (0.0, 0.0), (3.0, 0.0))
    assert len(results) == 200
    assert (results[-1][2], results[-1][3], results[-1][4]["outcome"]) == (False, True, "timeout")
    environment = tasks.load("nav_empty", random=0, config=NavigationConfig(time_limit_steps=5))
    steps = [environment.step([0.0, 0.0]) for _ in range(6)]
    assert (steps[-1].last(), steps[-1].discount) == (True, 1.0)
    assert [step.discount for step in steps[1:-1]] == [1.0] * 4


def test_a_goal_reached_in_the_last_step_terminates() -> None:
    steps = len(drive(make(), (0.5, 0.0), (2.5, 0.0)))
    results = drive(make(config=NavigationConfig(time_limit_steps=steps)), (0.5, 0.0), (2.5, 0.0))
    assert (results[-1][2], results[-1][3], results[-1][4]["outcome"]) == (True, False, "reached")


def test_dense_reward_adds_up_to_the_progress() -> None:
    results = drive(make(), (0.5, 0.0), (2.5, 0.0))
    running = results[:-1]
    progress = sum(result[4]["reward_terms"]["progress"] for result in running)
    assert progress == pytest.approx(2.5 - running[-1][4]["distance"], abs=1e-6)
    for _, reward, _, _, info in results:
        assert reward == pytest.approx(sum(info["reward_terms"].values()))
        assert set(info["reward_terms"]) == {"progress", "time", "reach", "crash"}
        assert len(info["pose"]) == 3


def test_complex_is_sparse_and_the_others_dense_by_default() -> None:
    for name, reward in (("nav_empty", -0.01), ("nav_simple", -0.01), ("nav_complex", -REWARDS["sparse"].time_penalty)):
        (result,) = drive(make(name), (0.0, 0.0), (3.0, 0.0), steps=1)
        assert result[1] == pytest.approx(reward, abs=1e-4)


def test_the_factor_of_the_paper_scales_progress() -> None:
    terms = Reward(progress=0.2, time_penalty=0.01).terms(Outcome.RUNNING, 1.0, 0.9)
    assert sum(terms.values()) == pytest.approx(0.1 * 0.2 - 0.01)


def test_a_start_may_be_given() -> None:
    environment = make()
    _, info = environment.reset(options={"start": (1.0, -1.0, 0.5), "goal": (3.0, 0.0)})
    np.testing.assert_allclose(info["pose"], (1.0, -1.0, 0.5), atol=1e-9)
    _, info = environment.reset()
    np.testing.assert_allclose(info["pose"], (0.0, 0.0, 0.0), atol=1e-9)


def test_scans_are_stacked_newest_first() -> None:
    environment = make("nav_complex")
    first, _ = environment.reset(seed=0)
    np.testing.assert_array_equal(first[:40], first[40:80])
    np.testing.assert_array_equal(first[:40], first[80:120])
    second = environment.step(np.array([0.5, 0.5]))[0]
    third = environment.step(np.array([0.5, 0.5]))[0]
    np.testing.assert_array_equal(second[40:80], first[:40])
    np.testing.assert_array_equal(third[40:80], second[:40])
    np.testing.assert_array_equal(third[80:120], first[:40])
    assert not np.array_equal(third[:40], second[:40])


def test_commands_beyond_the_bounds_are_clipped() -> None:
    fast, bound = (drive(make(), (speed, 0.0), (2.5, 0.0))[-1][4]["pose"] for speed in (3.0, 0.5))
    np.testing.assert_array_equal(fast, bound)


@pytest.mark.parametrize(
    "options",
    [
        {"gaol": (1.0, 1.0)}, {"start": (0.0, 0.0, 0.0)}, {"goal": (1.0, 1.0), "yaw": 0.0}, "goal", [1.0],
        *({"goal": goal} for goal in ((1.0,), "12", ("1", "2"), (math.nan, 0.0), (True, False), (10**400, 1), None)),
        *({"goal": (3.0, 0.0), "start": start} for start in ((0.0, 0.0), (0.0, 0.0, math.inf), "123", (0.0, "0", 0.0))),
    ],
)  # fmt: skip
def test_reset_options_that_are_no_start_and_goal_are_refused(options: Any) -> None:
    with pytest.raises(TaskError, match=r"reset options are goal|the (goal|start) must be [23] finite numbers"):
        make().reset(options=options)


@pytest.mark.parametrize(
    ("start", "sentence"),
    [
        ((9.0, 0.0, 0.0), "a start must lie in the room, x from -4.1 to 4.1 m"),
        ((4.0, 0.0, 0.0), "a start must lie on free floor; at .4, 0. there is an obstacle"),
        ((3.85, 0.0, 0.0), "a start must leave the robot free; at .3.85, 0, 0. it touches an obstacle"),
        ((0.35, -1.9, 0.0), "it touches an obstacle"),  # a carton, which can be pushed
    ],
)
def test_a_start_where_the_robot_does_not_fit_is_refused_and_the_episode_goes_on(
    start: tuple[float, float, float], sentence: str
) -> None:
    environment = make("nav_gazebo")
    environment.reset(seed=1)
    expected = make("nav_gazebo")
    expected.reset(seed=1)
    with pytest.raises(TaskError, match=sentence):
        environment.reset(seed=2, options={"start": start, "goal": (2.0, 2.0)})
    with pytest.raises(TaskError, match=sentence):
        environment.unwrapped._task.set_next_pair(environment.unwrapped.physics, Pose(*start), (2.0, 2.0))
    for _ in range(3):
        np.testing.assert_equal(environment.step(np.zeros(2)), expected.step(np.zeros(2)))
    np.testing.assert_equal(environment.reset(), expected.reset())


def test_a_step_after_the_end_is_refused() -> None:
    environment = make()
    drive(environment, (0.5, 0.0), (2.5, 0.0))
    with pytest.raises(gymnasium.error.ResetNeeded):
        environment.step(np.zeros(2))


@pytest.mark.parametrize("camera", ["chase", "top", "onboard"])
def test_pictures_show_the_room(camera: str) -> None:
    environment = make("nav_complex", render_mode="rgb_array", camera=camera, width=160, height=120)
    environment.reset(seed=0)
    picture = environment.render()
    assert (picture.shape, picture.dtype) == ((120, 160, 3), np.uint8)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50
    environment.close()
    environment.close()


def test_a_reset_clears_crash_and_pushed_things() -> None:
    environment = gymnasium.make("asddpg/NavGazebo-v0")
    pushed = 0
    # The small carton stands at (0.35, -2.1): drive at it from 1 m off.
    environment.reset(seed=0, options={"start": (0.35, -1.2, -math.pi / 2), "goal": (2.0, 2.0)})
    for _ in range(12):
        _, _, terminated, _, info = environment.step(np.array([0.5, 0.0], dtype=np.float32))
        pushed = max(pushed, info["pushed"])
        assert not terminated
    assert pushed == 1
    assert info["outcome"] == "running"
    _, info = environment.reset()
    assert info["pushed"] == 0
    assert not environment.get_wrapper_attr("physics").crashed()


@pytest.mark.parametrize(
    ("config", "values", "sentence"),
    [
        (NavigationConfig, {"control_timestep": 0.013}, "multiple of the physics step"),
        (NavigationConfig, {"goal_radius": -1.0}, "goal_radius must be from 0.1 to 2 m"),
        (NavigationConfig, {"max_linear_velocity": 3.0}, "up to the robot's 1.199"),
        (NavigationConfig, {"max_angular_velocity": -1.0}, "above 0"),
        (LaserConfig, {"noise": -1.0}, "noise must be 0 or more"),
        (LaserConfig, {"dropout": 1.5}, "dropout must be from 0 to 1"),
        (LaserConfig, {"latency": math.nan}, "latency must be a finite number"),
        (LaserConfig, {"num_beams": 1}, "num_beams must be from 2 to 2000"),
        (LaserConfig, {"num_beams": 40.5}, "num_beams must be a whole number"),
    ],
)
def test_a_constant_out_of_range_is_refused_at_every_entrance(
    config: type, values: dict[str, Any], sentence: str
) -> None:
    changed = config()
    vars(changed).update(values)
    task_values, whole = ({"laser": values}, {"laser": changed}) if config is LaserConfig else (values, changed)
    entrances: list[Callable[[], Any]] = [
        lambda: config(**values),
        lambda: NavigationConfig(**task_values),
        lambda: tasks.load("nav_empty", config=task_values),
        lambda: tasks.load("nav_empty", config=whole),
        lambda: make(config=task_values),
    ]
    for entrance in entrances:
        with pytest.raises(TaskError, match=sentence):
            entrance()
    (name,) = values
    group = "task.laser" if config is LaserConfig else "task"
    with pytest.raises(UserError, match=sentence):
        train_config([f"{group}.{name}={values[name]}"])


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"task": "nav_foo"}, "no task 'nav_foo'; there are nav_empty"),
        ({"task": ["nav_empty"]}, "no task"),
        ({"reward": "lush"}, "no reward 'lush'; there are dense, sparse"),
        ({"reward": ""}, "no reward ''"),
        ({"reward": 5}, "reward must be a Reward or a mapping of its options, not 5"),
        ({"reward": {"reach": -1}}, "reach must be 0 or more"),
        ({"reward": {"rich": 1}}, "reward has no option 'rich'; there are name, progress"),
        ({"config": 5}, "config must be a NavigationConfig or a mapping"),
        ({"config": {"radius": 1}}, "config has no option 'radius'; there are control_timestep"),
        ({"config": {"laser": None}}, "laser must be a LaserConfig or a mapping"),
        ({"num_scans": 0}, "num_scans must be from 1 to 100, not 0"),
        ({"num_scans": True}, "num_scans must be a whole number, not True"),
        ({"num_scans": 1.5}, "num_scans must be a whole number"),
        ({"width": 0}, "within 1920 x 1080 px, not 0 x 360"),
        ({"height": 5000}, "within 1920 x 1080 px"),
        ({"width": "64"}, "width must be a whole number"),
        ({"camera": "sideways"}, "no camera 'sideways'; there are top, chase, onboard, free"),
        ({"camera": None}, "camera must be"),
        ({"render_mode": "ansi"}, "render_mode must be rgb_array or None"),
    ],
)
def test_an_argument_that_fits_nothing_is_refused_when_the_environment_is_made(
    arguments: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(TaskError, match=sentence):
        NavigationEnv(**{"task": "nav_complex"} | arguments)
    if arguments.keys() <= {"task", "reward", "config"}:
        with pytest.raises(TaskError, match=sentence):
            tasks.load(arguments.get("task", "nav_complex"), **{k: v for k, v in arguments.items() if k != "task"})


def test_numbers_of_numpy_are_numbers() -> None:
    numbers: dict[str, Any] = {"num_beams": np.int64(60), "noise": np.float32(0.2)}
    config = LaserConfig(**numbers)
    assert (config, type(config.num_beams), type(config.noise)) == (LaserConfig(60, 0.2), int, float)
    sizes: Any = {"num_scans": np.int64(2), "width": np.uint16(64), "height": np.int32(48)}
    environment = NavigationEnv("nav_complex", config=NavigationConfig(laser=config), **sizes)
    assert environment.observation_space.shape == (2 * 60 + 4,)


# Another goal in mid-episode ---------------------------------------------------------------------------


def test_a_moved_goal_is_seen_and_rewarded_at_once_and_moves_nothing_else() -> None:
    states = []
    for goal in (None, (3.0, -2.5)):
        env = NavigationEnv("nav_complex", reward="dense")
        env.reset(seed=1)
        observation, *_ = env.step(np.array([0.3, 0.1]))
        before = 0.0
        if goal is not None:
            moved = env.set_goal(*goal)
            x, y, _ = env.physics.pose()
            assert moved[:-2].tolist() == observation[:-2].tolist()
            assert np.hypot(*moved[-2:]) == pytest.approx(np.hypot(goal[0] - x, goal[1] - y), abs=1e-5)
            before = env.physics.readings().goal_distance
        for _ in range(3):
            observation, _, _, _, info = env.step(np.array([0.3, 0.1]))
            if goal is not None:
                assert info["reward_terms"]["progress"] == pytest.approx(before - info["distance"])
                before = info["distance"]
        states.append(env.physics.state_digest())
    assert states[0] == states[1]


@pytest.mark.parametrize(
    ("goal", "sentence"),
    [
        ((9.0, 0.0), "a goal must lie in the room"), ((0.0, 2.0), "a goal must lie on free floor"),
        ((4.05, 0.0), "free floor"), ((np.nan, 0.0), "the goal must be 2 finite numbers"), (("2", 0.0), "must be 2"),
    ],
)  # fmt: skip
def test_a_goal_outside_free_space_is_refused_at_every_entrance(goal: tuple[float, float], sentence: str) -> None:
    env = NavigationEnv("nav_complex")
    with pytest.raises(TaskError, match="no episode"):
        env.set_goal(0.0, 0.0)
    env.reset(seed=1)
    before = env.physics.goal()
    with pytest.raises(TaskError, match=sentence):
        env.set_goal(*goal)
    with pytest.raises(TaskError, match=sentence):
        env.reset(options={"goal": goal})
    assert env.physics.goal() == before
