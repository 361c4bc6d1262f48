"""An environment's state, its copies and its pickles go on equal to the last bit; over the registry."""

import copy
import multiprocessing
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import tasks
from asddpg.runs import state_files
from tasks.errors import TaskError
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.laser import LaserConfig
from tasks.navigation import NavigationConfig

EVERY_TASK = pytest.mark.parametrize("name", tasks.ALL_TASKS)
LASERS = {
    "perfect": LaserConfig(),
    "disturbed": LaserConfig(noise=1.0, dropout=0.1),
    "late": LaserConfig(noise=1.0, latency=0.47),
}


def make(name: str, laser: str = "perfect", **options: Any) -> Any:
    config = NavigationConfig(laser=LASERS[laser], time_limit_steps=45)  # so that 50 steps see a reset, drawn anew
    return gymnasium.make(tasks.gymnasium_id(name), config=config, **options)


def drive(environment: Any, steps: int, seed: int = 0, is_begun: bool = True) -> list[Any]:
    """Random commands; the results and the state of physics. It resets after an episode."""
    rng, physics, results = np.random.default_rng(seed), environment.unwrapped.physics, []
    for _ in range(steps):
        if is_begun:
            result: Any = environment.step(rng.uniform(*environment.action_space.high * [[0, -1], [1, 1]]))
            is_begun = not (result[2] or result[3])
        else:
            result, is_begun = environment.reset(), True
        data = physics.data.ptr
        results.append((result, data.qpos.copy(), data.qvel.copy(), data.qacc_warmstart.copy(), physics.ranges()))
    return results


def restored(environment: Any, **options: Any) -> Any:
    """Another environment, which has driven elsewhere, with the state of the first."""
    other = make(environment.unwrapped.state()["task_name"], **options)
    other.reset(seed=99)
    drive(other, 3)
    other.unwrapped.load_state(environment.unwrapped.state())
    return other


COPIES: dict[str, Callable[..., Any]] = {
    "load_state": restored,
    "deepcopy": lambda environment, **_: copy.deepcopy(environment),
    "pickle": lambda environment, **_: pickle.loads(pickle.dumps(environment)),
}


@EVERY_TASK
@pytest.mark.parametrize("laser", LASERS)
def test_a_copy_in_mid_episode_goes_on_equal_to_the_last_bit(name: str, laser: str) -> None:
    environment = make(name, laser)
    environment.reset(seed=5)
    drive(environment, 7)
    environment.unwrapped.set_goal(0.75, 0.75)
    copies = [make_copy(environment, laser=laser) for make_copy in COPIES.values()]
    expected = drive(environment, 50, seed=1)
    for copied in copies:
        np.testing.assert_equal(drive(copied, 50, seed=1), expected)


@pytest.mark.parametrize("make_copy", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("name", ["nav_complex", "nav_gazebo"])
def test_a_copy_goes_on_equal_before_the_first_reset_after_it_and_after_an_episode(
    name: str, make_copy: Callable[..., Any]
) -> None:
    environment = make(name, "late")
    for is_begun in (False, True, False):
        copied = make_copy(environment, laser="late")
        np.testing.assert_equal(drive(copied, 50, is_begun=is_begun), drive(environment, 50, is_begun=is_begun))
        environment.reset(seed=6)
        if is_begun:
            while not any(environment.step(np.array([0.5, 0.0]))[2:4]):
                pass


@pytest.mark.parametrize("steps", [0, 1, 7])
def test_a_restored_environment_gives_the_observation_and_info_of_the_present(steps: int) -> None:
    environment = NavigationEnv("nav_gazebo")
    present = environment.reset(seed=5)
    for _ in range(steps):
        observation, *_, info = environment.step(np.array([0.5, 0.5]))
        present = observation, info
    np.testing.assert_equal(NavigationEnv("nav_gazebo").load_state(environment.state()), present)


def drive_from_files(folder: Path, results: Any) -> None:
    environment = make("nav_gazebo", "late")
    environment.unwrapped.load_state(state_files.read(folder))
    results.put(drive(environment, 50))


def test_a_state_goes_through_files_into_another_process(tmp_path: Path) -> None:
    environment = make("nav_gazebo", "late")
    environment.reset(seed=5)
    drive(environment, 7)
    state_files.write(tmp_path, environment.unwrapped.state())
    context = multiprocessing.get_context("spawn")
    results = context.Queue()
    process = context.Process(target=drive_from_files, args=(tmp_path, results))
    process.start()
    np.testing.assert_equal(results.get(timeout=60), drive(environment, 50))
    process.join()


@EVERY_TASK
@pytest.mark.parametrize("make_copy", COPIES.values(), ids=COPIES)
def test_a_copy_of_an_environment_that_has_rendered_goes_on_equal_and_renders_itself(
    make_copy: Callable[..., Any], name: str
) -> None:
    options: dict[str, Any] = {"render_mode": "rgb_array", "width": 64, "height": 48}
    environment = make(name, **options)
    environment.reset(seed=5)
    drive(environment, 3)
    environment.render()
    copied = make_copy(environment, **options)
    np.testing.assert_equal(drive(copied, 50), drive(environment, 50))
    np.testing.assert_equal(copied.render(), environment.render())
    copied.close()
    environment.close()


@EVERY_TASK
def test_a_copied_dm_control_environment_goes_on_equal(name: str) -> None:
    environment = tasks.load(name, random=3)
    for _ in range(7):
        environment.step([0.5, 0.5])
    copied = copy.deepcopy(environment), pickle.loads(pickle.dumps(environment))
    expected = [environment.step([0.4, -0.3]) for _ in range(50)]
    for other in copied:
        np.testing.assert_equal([other.step([0.4, -0.3]) for _ in range(50)], expected)


def test_a_copied_physics_has_the_readings_and_next_steps_of_the_first() -> None:
    environment = tasks.load("nav_gazebo", random=3)
    for _ in range(7):
        environment.step([0.5, 0.5])
    physics = environment.physics
    copies = [physics.copy(), physics.copy(share_model=True), copy.deepcopy(physics)]
    readings = [(each.sensor("accelerometer"), each.sonar_ranges(), each.state()) for each in (physics, *copies)]
    for each in (physics, *copies):
        each.step(40)
    for reading, other in zip(readings, copies, strict=False):
        np.testing.assert_equal(reading, readings[0])
        np.testing.assert_equal(other.full_state(), physics.full_state())


def test_a_motion_set_within_a_reset_feels_the_wheels_from_its_first_step() -> None:
    first, second = (tasks.load("nav_empty").physics for _ in range(2))
    for physics in (first, second):
        with physics.reset_context():
            physics.data.ptr.qvel[:] = 0.1
    second.forward()
    for physics in (first, second):
        physics.step(1)
    np.testing.assert_equal(first.data.ptr.qvel, second.data.ptr.qvel)


@pytest.mark.parametrize(
    ("other", "sentence"),
    [
        (NavigationEnv("nav_simple"), "nav_simple, and the environment of nav_complex"),
        (NavigationEnv("nav_complex", num_scans=5), "204 numbers, not 124"),
    ],
)
def test_a_state_of_another_scene_is_refused_in_a_sentence(other: NavigationEnv, sentence: str) -> None:
    environment = NavigationEnv("nav_complex")
    with pytest.raises(TaskError, match=sentence):
        environment.load_state(other.state())
    state = environment.state()
    state["physics"]["integration"] = np.zeros(3)
    with pytest.raises(TaskError, match="it has 3 numbers"):
        environment.load_state(state)
