"""The laser against an analytic ray caster, and its noise, dropout and latency."""

import math
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

import tasks
from tasks import constants
from tasks.laser import BeamRing
from tasks.physics import Physics, Pose
from tasks.registry import ROOM_TASKS
from tasks.scene.loading import open_scene, scene_path
from tests.support import ray_caster

POSES = 1000
LASER = (0.1, 0.0, 0.287)  # in the robot's frame, metres


def expected_ranges(physics: Physics, count: int) -> npt.NDArray[np.float64]:
    """The scan of the present state by analysis."""
    model, data = physics.model.ptr, physics.data.ptr
    base = model.body("base").id
    robot = set(np.flatnonzero(model.body_rootid == base).tolist())
    matrix = np.zeros(9)
    pose = data.joint("base").qpos
    mujoco.mju_quat2Mat(matrix, pose[3:])
    rotation = matrix.reshape(3, 3)
    origin = pose[:3] + rotation @ LASER
    angles = BeamRing(count).angles()
    directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=1) @ rotation.T
    lengths = ray_caster.lengths(origin, directions, model, data, robot)
    return np.clip(lengths, constants.MIN_RANGE, constants.MAX_RANGE)


@pytest.mark.parametrize("name", ROOM_TASKS)
def test_every_beam_is_the_analytic_one(name: str) -> None:
    physics = open_scene(scene_path(name))
    rng, model, worst = np.random.default_rng(0), physics.model.ptr, 0.0
    reach = float(np.abs(model.geom_pos[model.geom_bodyid == 0][:, :2]).max())
    for _ in range(POSES // len(ROOM_TASKS) + 1):
        with physics.reset_context():
            x, y, yaw = rng.uniform([-reach, -reach, -math.pi], [reach, reach, math.pi])
            physics.set_pose(Pose(x, y, yaw))
        worst = max(worst, float(np.abs(physics.ranges() - expected_ranges(physics, 40)).max()))
    assert worst < 1e-3


@pytest.mark.parametrize("name", ROOM_TASKS)
def test_no_beam_and_no_sonar_sees_the_robot(name: str) -> None:
    """Without the room every ray must miss."""
    physics = open_scene(scene_path(name))
    model = physics.model.ptr
    in_room = model.body_rootid[model.geom_bodyid] != model.body("base").id
    model.geom_rgba[in_room, 3] = 0.0
    model.geom_matid[in_room] = -1
    rng = np.random.default_rng(0)
    for _ in range(20):
        with physics.reset_context():
            physics.set_pose(Pose(0.0, 0.0, rng.uniform(-math.pi, math.pi)))
            physics.data.ptr.joint("left_wheel").qpos = rng.uniform(-3, 3)
            physics.data.ptr.joint("caster_swivel").qpos = rng.uniform(-3, 3)
        assert np.all(physics.ranges() == constants.MAX_RANGE)
        assert np.all(physics.sonar_ranges() == constants.MAX_SONAR_RANGE)


def test_scan_and_pose_belong_to_the_same_instant_on_a_spinning_robot() -> None:
    physics = open_scene(scene_path("nav_complex"))
    with physics.reset_context():
        physics.set_pose(Pose(0.0, 0.0, 0.0))
    physics.set_velocity_command(0.0, math.pi / 3)
    for _ in range(20):
        physics.step(40)
        np.testing.assert_allclose(physics.ranges(), expected_ranges(physics, 40), atol=1e-3)


@pytest.mark.parametrize("count", [40, 682])
def test_the_ring_is_one_definition_with_another_count(count: int) -> None:
    physics = open_scene(scene_path("nav_complex"), ring=BeamRing(count))
    assert physics.num_beams == count
    with physics.reset_context():
        physics.set_pose(Pose(0.3, -0.4, 1.0))
    np.testing.assert_allclose(physics.ranges(), expected_ranges(physics, count), atol=1e-3)


def observations(config: tasks.LaserConfig, seed: int = 0, steps: int = 8) -> tuple[Any, list[Any]]:
    environment = tasks.load("nav_complex", random=seed, config=tasks.NavigationConfig(laser=config))
    seen = [environment.reset().observation["ranges"]]
    states = [environment.physics.get_state()]
    for _ in range(steps):
        seen.append(environment.step((0.2, 0.8)).observation["ranges"])
        states.append(environment.physics.get_state())
    return np.array(seen), states


def test_noise_is_seeded_and_as_large_as_in_the_data_sheet() -> None:
    clean, _ = observations(tasks.LaserConfig(), steps=100)
    noisy, states = observations(tasks.LaserConfig(noise=1.0), steps=100)
    again, same_states = observations(tasks.LaserConfig(noise=1.0), steps=100)
    np.testing.assert_array_equal(noisy, again)
    np.testing.assert_array_equal(states, same_states)
    hit = clean < constants.MAX_RANGE - 0.2
    assert (noisy - clean)[hit].std() == pytest.approx(0.028, rel=0.05)
    assert abs((noisy - clean)[hit].mean()) < 0.003
    np.testing.assert_array_equal(noisy[clean == constants.MAX_RANGE], constants.MAX_RANGE)


def test_options_of_the_laser_change_neither_goal_nor_motion() -> None:
    _, plain = observations(tasks.LaserConfig())
    for config in (tasks.LaserConfig(noise=1.0, dropout=0.1), tasks.LaserConfig(num_beams=60)):
        np.testing.assert_array_equal(observations(config)[1], plain)


def test_dropped_returns_read_the_maximum() -> None:
    clean, _ = observations(tasks.LaserConfig(), steps=100)
    dropped, _ = observations(tasks.LaserConfig(dropout=0.2), steps=100)
    hit = clean < constants.MAX_RANGE
    lost = dropped != clean
    assert np.all(dropped[lost] == constants.MAX_RANGE)
    assert lost[hit].mean() == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize("steps", [1, 3])
def test_latency_of_whole_control_steps_is_an_older_scan(steps: int) -> None:
    clean, _ = observations(tasks.LaserConfig())
    late, _ = observations(tasks.LaserConfig(latency=0.2 * steps))
    np.testing.assert_array_equal(late[: steps + 1], clean[[0] * (steps + 1)])
    np.testing.assert_array_equal(late[steps:], clean[:-steps])


def test_latency_below_a_control_step_is_the_scan_of_that_instant() -> None:
    def drive(latency: float, control_timestep: float) -> Any:
        config = tasks.NavigationConfig(control_timestep=control_timestep, laser=tasks.LaserConfig(latency=latency))
        environment = tasks.load("nav_complex", random=0, config=config)
        environment.reset()
        steps = round(0.4 / control_timestep)
        return np.array([environment.step((0.2, 0.8)).observation["ranges"] for _ in range(steps)])

    fine, late = drive(0.0, 0.05), drive(0.05, 0.2)
    # The scans of 0.15 s and 0.35 s.
    np.testing.assert_allclose(late, fine[[2, 6]], atol=1e-6)


def test_a_scan_read_twice_is_the_same_scan() -> None:
    environment = tasks.load("nav_complex", random=0, config=tasks.NavigationConfig(laser=tasks.LaserConfig(noise=1.0)))
    first = environment.reset().observation["ranges"]
    task = environment.task
    np.testing.assert_array_equal(task.get_observation(environment.physics)["ranges"], first)
