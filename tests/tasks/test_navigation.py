"""Rewards, ends and options of the task, through Gymnasium."""

import math
from typing import Any

import gymnasium
import numpy as np
import pytest

import tasks
from asddpg.command_line import train_config
from asddpg.errors import UserError
from tasks import NavigationConfig, Reward
from tasks.errors import TaskError
from tasks.gymnasium_api.navigation_env import NavigationEnv
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


def test_without_a_goal_radius_no_episode_ends_at_its_goal() -> None:
    config = NavigationConfig(goal_radius=0.0, time_limit_steps=28)
    for action, goal in (((0.5, 0.0), (2.5, 0.0)), ((0.0, 0.0), (0.0, 0.0))):
        results = drive(make(config=config), action, goal)
        assert min(info["distance"] for *_, info in results) < 0.06
        assert (len(results), results[-1][4]["outcome"]) == (28, "timeout")


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
    environment = make("nav_complex", num_scans=np.int64(3))
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
        ((9.0, 0.0, 0.0), "start must lie in the room, x from -4.1"), ((4.0, 0.0, 0.0), "start must lie on free floor"),
        ((3.85, 0.0, 0.0), "must leave the robot free; at .3.85, 0, 0. it touches an obstacle"),
        ((0.35, -1.9, 0.0), "it touches an obstacle"),  # a carton, which can be pushed
    ],
)  # fmt: skip
def test_a_start_where_the_robot_does_not_fit_is_refused_and_the_episode_goes_on(
    start: tuple[float, float, float], sentence: str
) -> None:
    environment, expected = make("nav_gazebo"), make("nav_gazebo")
    for each in (environment, expected):
        each.reset(seed=1)
    with pytest.raises(TaskError, match=sentence):
        environment.reset(seed=2, options={"start": start, "goal": (2.0, 2.0)})
    np.testing.assert_equal(environment.step(np.zeros(2)), expected.step(np.zeros(2)))
    np.testing.assert_equal(environment.reset(), expected.reset())


def test_a_reset_that_an_invalid_seed_refuses_changes_nothing() -> None:
    environment, expected = make(), make()
    for each in (environment, expected):
        each.reset(seed=1)
    with pytest.raises(gymnasium.error.Error):
        environment.reset(seed=-1, options={"goal": (1.5, 1.5)})
    np.testing.assert_equal(environment.reset(), expected.reset())


@pytest.mark.parametrize("action", [("a", "b"), 3.0, [1, 2, 3], [[1, 2]], None])
def test_an_action_that_is_not_two_numbers_is_refused_and_the_episode_goes_on(action: Any) -> None:
    environment, expected = make(), make()
    for each in (environment, expected):
        each.reset(seed=1)
    with pytest.raises(TaskError, match="an action is two numbers"):
        environment.step(action)
    np.testing.assert_equal(environment.step(np.array([0.3, 0.1])), expected.step(np.array([0.3, 0.1])))


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
    ("name", "value", "sentence"),
    [
        ("control_timestep", 0.013, "multiple of the physics step"), ("goal_radius", -1.0, "0, or from 0.1 to 2 m"),
        ("max_linear_velocity", 3.0, "up to the robot's 1.199"), ("max_angular_velocity", -1.0, "above 0"),
        ("time_limit_steps", 0, "greater than 0"), ("laser.noise", -1.0, "noise must be 0 or more"),
        ("laser.dropout", 1.5, "from 0 to 1"), ("laser.latency", math.nan, "latency must be a finite number"),
        ("laser.num_beams", 1, "must be from 2 to 2000"), ("laser.num_beams", 40.5, "must be a whole number"),
    ],
)  # fmt: skip
def test_a_constant_out_of_range_is_refused_at_every_entrance(name: str, value: Any, sentence: str) -> None:
    is_laser, field = name.startswith("laser."), name.split(".")[-1]
    mapping: dict[str, Any] = {"laser": {field: value}} if is_laser else {field: value}
    changed = NavigationConfig()
    setattr(changed.laser if is_laser else changed, field, value)
    for entrance in (
        lambda: NavigationConfig(**mapping), lambda: make(config=mapping),
        lambda: tasks.load("nav_empty", config=mapping), lambda: tasks.load("nav_empty", config=changed),
    ):  # fmt: skip
        with pytest.raises(TaskError, match=sentence):
            entrance()
    with pytest.raises(UserError, match=sentence):
        train_config([f"task.{name}={value}"])


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"task": "nav_foo"}, "no task 'nav_foo'; there are nav_empty"), ({"task": ["nav_empty"]}, "no task"),
        ({"reward": "lush"}, "no reward 'lush'; there are dense, sparse"), ({"reward": ""}, "no reward ''"),
        ({"reward": 5}, "reward must be a Reward or a mapping of its options, not 5"),
        ({"reward": {"reach": -1}}, "reach must be 0 or more"), ({"reward": {"rich": 1}}, "no option 'rich'; there"),
        ({"config": 5}, "config must be a NavigationConfig or a mapping"), ({"config": {"laser": 5}}, "laser must be"),
        ({"num_scans": 0}, "num_scans must be from 1 to 100"), ({"num_scans": True}, "must be a whole number"),
        ({"width": 0}, "within 1920 x 1080 px, not 0 x 360"), ({"height": 5000}, "within 1920 x 1080 px"),
        ({"camera": "sideways"}, "no camera 'sideways'; there are top, chase, onboard, free"),
        ({"render_mode": "ansi"}, "render_mode must be rgb_array or None"), ({"width": 64.5}, "must be a whole number"),
    ],
)  # fmt: skip
def test_an_invalid_argument_is_refused_when_the_environment_is_made(arguments: dict[str, Any], sentence: str) -> None:
    with pytest.raises(TaskError, match=sentence):
        NavigationEnv(**{"task": "nav_complex"} | arguments)
    if arguments.keys() <= {"reward", "config"}:
        with pytest.raises(TaskError, match=sentence):
            tasks.load("nav_complex", **arguments)


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
