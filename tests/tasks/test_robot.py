"""The Pioneer against analysis: how it drives, brakes, stands and measures."""

import math
from typing import Any

import numpy as np
import pytest

from tasks import constants
from tasks.physics import Physics, Pose
from tasks.registry import ROOM_TASKS, make_rule
from tasks.scene.loading import open_scene, scene_path

ACCELERATION_LIMIT, BRAKING_LIMIT = 1.8, 1.85  # m/s², models/mjcf/pioneer/README.md
ON_THE_FLOOR = ("left_wheel", "right_wheel", "caster")


def robot(x: float = 0.0, timestep: float | None = None) -> Physics:
    physics = open_scene(scene_path("nav_empty"))
    if timestep is not None:
        physics.model.ptr.opt.timestep = timestep
    with physics.reset_context():
        physics.set_pose(Pose(x, 0.0, 0.0))
    return physics


def drive(physics: Physics, linear: float, angular: float, seconds: float) -> None:
    physics.set_velocity_command(linear, angular)
    physics.step(round(seconds / physics.timestep()))


def heights(physics: Any) -> list[float]:
    """Height of the lowest point of each wheel above the floor, metres: negative where it sinks in."""
    model, data = physics.model.ptr, physics.data.ptr
    lowest = []
    for name in ON_THE_FLOOR:
        size, rotation = model.geom(name).size, data.geom(name).xmat.reshape(3, 3)
        lowest.append(data.geom(name).xpos[2] - np.linalg.norm(rotation[2] * size))
    return lowest


def test_resting_robot_stands_on_three_wheels_within_a_millimetre() -> None:
    physics = robot()
    drive(physics, 0.0, 0.0, 2.0)
    assert np.all(np.abs(heights(physics)) < 1e-3)
    assert math.dist(physics.pose()[:2], (0.0, 0.0)) < 1e-4


def test_a_step_of_the_command_is_followed_within_the_limits() -> None:
    physics = robot(x=-3.0)
    drive(physics, 0.0, 0.0, 1.0)
    seen = []
    for target in (0.5, 0.0):
        physics.set_velocity_command(target, 0.0)
        for _ in range(200):
            physics.step(1)
            seen.append(physics.readings().velocity.linear)
            assert np.all(np.array(heights(physics)) < 1e-3), "a wheel leaves the floor"
    up, down = np.array(seen[:200]), np.array(seen[200:])
    accelerations = (np.array(seen)[10:] - np.array(seen)[:-10]) / (10 * physics.timestep())
    assert 0.95 * ACCELERATION_LIMIT < accelerations.max() <= ACCELERATION_LIMIT
    assert -BRAKING_LIMIT <= accelerations.min() < -0.95 * ACCELERATION_LIMIT
    assert up.max() < 0.5 * 1.05
    assert down.min() > -0.5 * 0.05
    for speeds, target in ((up, 0.5), (down, 0.0)):
        late = np.flatnonzero(np.abs(speeds - target) > 0.01)[-1] * physics.timestep()
        assert late < 1.0
    # v² / 2a at the limit, and no shorter.
    braking = down.sum() * physics.timestep()
    assert braking == pytest.approx(0.5**2 / (2 * ACCELERATION_LIMIT), rel=0.1)


def test_a_command_above_the_limits_saturates() -> None:
    physics = robot(x=-3.5)
    drive(physics, 10.0, 0.0, 3.0)
    limit = constants.WHEEL_SPEED_LIMIT * constants.WHEEL_RADIUS
    assert physics.readings().velocity.linear == pytest.approx(limit, rel=0.01)
    for sensor in ("left_wheel_speed", "right_wheel_speed"):
        assert physics.sensor(sensor).item() == pytest.approx(constants.WHEEL_SPEED_LIMIT, rel=0.01)
    physics = robot()
    drive(physics, 0.0, 100.0, 2.0)
    assert physics.readings().velocity.angular == pytest.approx(constants.TURN_RATE_LIMIT, rel=0.06)


def test_too_much_torque_would_slip() -> None:
    """Grip, not torque, bounds what the floor can give: on ice the same command moves the robot far less."""
    physics = robot()
    for name in ("left_wheel", "right_wheel"):
        physics.model.ptr.geom(name).friction[0] = 0.02
    physics.set_velocity_command(0.5, 0.0)
    physics.step(60)
    assert physics.sensor("left_wheel_speed").item() * constants.WHEEL_RADIUS > 2 * physics.readings().velocity.linear


def test_the_caster_swivels_behind() -> None:
    physics = robot(x=-3.0)
    address = int(physics.model.ptr.joint("caster_swivel").qposadr[0])
    physics.data.ptr.qpos[address] = 1.5
    drive(physics, 0.5, 0.0, 2.0)
    assert abs(physics.data.ptr.qpos[address]) < 0.05
    assert abs(physics.pose().y) < 0.01


def test_halving_the_physics_step_changes_little() -> None:
    ends = []
    for timestep in (0.005, 0.0025):
        physics, rng = robot(timestep=timestep), np.random.default_rng(0)
        for _ in range(25):
            drive(physics, rng.uniform(0.0, 0.5), rng.uniform(-math.pi / 3, math.pi / 3), 0.2)
        ends.append(physics.pose())
    assert math.dist(ends[0][:2], ends[1][:2]) < 0.03
    assert abs(math.remainder(ends[0].yaw - ends[1].yaw, 2 * math.pi)) < math.radians(2)


def test_sensors_agree_with_the_motion_and_reading_them_changes_nothing() -> None:
    physics, unread = robot(), robot()
    for each in (physics, unread):
        drive(each, 0.3, 0.5, 2.0)
    np.testing.assert_allclose(physics.sensor("velocimeter")[0], physics.readings().velocity.linear, atol=1e-3)
    np.testing.assert_allclose(physics.sensor("gyro")[2], physics.readings().velocity.angular, atol=1e-3)
    np.testing.assert_allclose(physics.sensor("position")[:2], physics.pose()[:2], atol=1e-9)
    # On the level at a steady turn: gravity, and v · ω towards the centre of the turn.
    np.testing.assert_allclose(physics.sensor("accelerometer"), [0.0, 0.3 * 0.5, 9.81], atol=0.03)
    np.testing.assert_array_equal(physics.sensor("bumper"), [0.0])
    turned = physics.sensor("right_encoder") - physics.sensor("left_encoder")
    arc = (turned * constants.WHEEL_RADIUS / constants.TRACK).item()
    assert arc == pytest.approx(physics.pose().yaw, rel=0.01)
    for each in (physics, unread):
        drive(each, 0.4, 0.6, 0.2)
    np.testing.assert_array_equal(physics.get_state(), unread.get_state())


def test_the_bumper_feels_a_wall() -> None:
    physics = robot(x=3.6)
    drive(physics, 0.5, 0.0, 2.0)
    assert physics.crashed()
    # Two motors of 0.88 N·m at 0.0975 m push with 18 N.
    assert physics.sensor("bumper").item() == pytest.approx(2 * 0.88 / 0.0975, rel=0.1)


def test_sonars_measure_the_walls() -> None:
    physics = robot()
    readings = physics.sonar_ranges()
    assert readings.shape == (16,)
    # sonar_00 looks left from y = 0.136, sonar_07 right; the walls stand at ±4 m.
    assert readings[[0, 7]] == pytest.approx([4 - 0.136] * 2, abs=1e-3)
    # The rear ones at ±170° look back from x = −0.255.
    expected = (4 - 0.255) / math.cos(math.radians(10))
    assert readings[[11, 12]] == pytest.approx([expected] * 2, abs=1e-3)


@pytest.mark.parametrize(("count", "seconds"), [(3, 12.0), pytest.param(20, 60.0, marks=pytest.mark.long)])
@pytest.mark.parametrize("name", ROOM_TASKS)
def test_random_driving_into_walls_and_things_keeps_all_wheels_down(name: str, count: int, seconds: float) -> None:
    for seed in range(count):
        physics, rng = open_scene(scene_path(name)), np.random.default_rng(seed)
        start, _ = make_rule(name, physics.model.ptr).draw(rng, np.zeros((0, 2)))
        with physics.reset_context():
            physics.set_pose(start._replace(yaw=rng.uniform(-math.pi, math.pi)))
        for _ in range(round(seconds / constants.CONTROL_TIMESTEP)):
            linear, angular = rng.uniform(0.0, 0.5), rng.uniform(-math.pi / 3, math.pi / 3)
            for _ in range(8):
                drive(physics, linear, angular, constants.CONTROL_TIMESTEP / 8)
                assert np.all(np.abs(heights(physics)) < 1e-3)
        assert not any(warning.number for warning in physics.data.ptr.warning)
        assert physics.data.ptr.body("base").xmat[8] > 0.999
