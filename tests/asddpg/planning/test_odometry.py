"""Wheel odometry and the motion model, against cases worked out by hand."""

import math

import numpy as np
import pytest

from asddpg.planning.odometry import (
    MotionNoise,
    OdometryErrors,
    RelativeMotion,
    WheelOdometry,
    relative_motion,
    sample_motion,
)

WHEEL_RADIUS, TRACK = 0.1, 0.4  # m
TURN = 2 * math.pi
FINE = 10**7  # ticks a revolution


def driven(left: float, right: float, steps: int = 1, errors: OdometryErrors | None = None) -> list[float]:
    """The pose after the wheels have turned so far, in revolutions."""
    odometry = WheelOdometry(WHEEL_RADIUS, TRACK, FINE, errors)
    for step in range(1, steps + 1):
        odometry.update((left * TURN * step / steps, right * TURN * step / steps))
    pose: list[float] = odometry.pose.tolist()
    return pose


def test_equal_wheels_drive_straight() -> None:
    assert driven(2.0, 2.0) == pytest.approx([2.0 * TURN * WHEEL_RADIUS, 0.0, 0.0])
    assert driven(-0.5, -0.5) == pytest.approx([-0.5 * TURN * WHEEL_RADIUS, 0.0, 0.0])


def test_opposite_wheels_spin() -> None:
    assert driven(-0.25, 0.25) == pytest.approx([0.0, 0.0, 2 * (math.pi / 2 * 0.1) / 0.4])
    assert driven(0.25, -0.25) == pytest.approx([0.0, 0.0, -2 * (math.pi / 2 * 0.1) / 0.4])


@pytest.mark.parametrize("steps", [1, 7, 100])
def test_a_quarter_circle_is_exact_however_long_the_steps(steps: int) -> None:
    # Radius 1 m to the left: the wheels drive π/2 times 0.8 m and 1.2 m, two and three revolutions.
    assert driven(2.0, 3.0, steps) == pytest.approx([1.0, 1.0, math.pi / 2], abs=1e-6)


def test_a_wheel_taken_for_5_percent_larger_bends_the_path() -> None:
    turn = 0.05 / 0.4  # 1 m of the left wheel, 1.05 m of the right one
    radius = 1.025 / turn
    pose = driven(10 / TURN, 10 / TURN, 20, OdometryErrors(right_radius=1.05))
    assert pose == pytest.approx([radius * math.sin(turn), radius * (1 - math.cos(turn)), turn], abs=1e-6)
    mirrored = driven(10 / TURN, 10 / TURN, 20, OdometryErrors(left_radius=1.05))
    assert mirrored == pytest.approx([pose[0], -pose[1], -pose[2]], abs=1e-6)


def test_a_track_taken_for_5_percent_longer_shortens_turns_only() -> None:
    errors = OdometryErrors(track=1.05)
    assert driven(-0.25, 0.25, 1, errors)[2] == pytest.approx(math.pi / 4 / 1.05)
    assert driven(2.0, 2.0, 1, errors) == pytest.approx(driven(2.0, 2.0))


def test_rounding_to_ticks_does_not_accumulate() -> None:
    odometry = WheelOdometry(WHEEL_RADIUS, TRACK, 100)
    for step in range(1, 1001):  # each a sixth of a tick
        odometry.update((0.01 * step, 0.01 * step))
    assert odometry.pose.tolist() == pytest.approx([159 * 0.1 * TURN / 100, 0.0, 0.0])  # 10 rad are 159.2 ticks


def test_reset_sets_the_pose_and_the_angles() -> None:
    odometry = WheelOdometry(WHEEL_RADIUS, TRACK, FINE)
    odometry.update((3.0, 4.0))
    odometry.reset((1.0, 2.0, math.pi / 2), (50.0, -20.0))
    assert odometry.update((50.0 + 5.0, -20.0 + 5.0)).tolist() == pytest.approx([1.0, 2.5, math.pi / 2], abs=1e-6)


def test_a_motion_is_a_turn_a_line_and_a_turn() -> None:
    assert relative_motion((1.0, 2.0, 0.0), (1.0, 3.0, math.pi)) == pytest.approx((math.pi / 2, 1.0, math.pi / 2))
    assert relative_motion((0.0, 0.0, 3.0), (-0.5, 0.0, -3.0)) == pytest.approx((math.pi - 3, 0.5, math.pi - 3))


def test_a_line_below_a_centimetre_has_no_turn_before_it() -> None:
    assert relative_motion((0.0, 0.0, 0.0), (0.0, 0.009, 0.5)) == pytest.approx((0.0, 0.009, 0.5))
    assert relative_motion((0.0, 0.0, 0.0), (0.0, 0.011, 0.5)) == pytest.approx((math.pi / 2, 0.011, 0.5 - math.pi / 2))


def test_standard_deviations_by_hand() -> None:
    found = MotionNoise(0.1, 0.2, 0.3, 0.4).deviations(RelativeMotion(0.3, 0.4, -0.1))
    assert np.square(found) == pytest.approx([0.009 + 0.032, 0.048 + 0.4 * (0.09 + 0.01), 0.001 + 0.032])


def test_backwards_is_as_certain_as_forwards() -> None:
    forwards, backwards = (relative_motion((0.0, 0.0, 0.0), (x, 0.0, 0.1)) for x in (0.5, -0.5))
    assert abs(backwards.rot1) == pytest.approx(math.pi)
    assert MotionNoise().deviations(backwards) == pytest.approx(MotionNoise().deviations(forwards))
    assert MotionNoise().deviations(forwards)[2] == pytest.approx(math.sqrt(0.2 * 0.01 + 0.2 * 0.25))


@pytest.mark.parametrize("after", [(1.2, 0.4, -2.0), (0.3, 0.5, 0.0), (0.5, 0.5, 3.0)])
def test_without_noise_particles_move_as_odometry_does(after: tuple[float, float, float]) -> None:
    before = (0.5, 0.5, 0.2)
    motion = relative_motion(before, after)
    (moved,) = sample_motion(np.array([before]), motion, MotionNoise(0, 0, 0, 0), np.random.default_rng(0))
    assert moved.tolist() == pytest.approx(after)


def test_particles_spread_as_the_deviations_say() -> None:
    motion, noise = RelativeMotion(0.1, 0.5, -0.2), MotionNoise(0.02, 0.01, 0.03, 0.04)
    start = np.zeros((100_000, 3))
    moved = sample_motion(start, motion, noise, np.random.default_rng(0))
    first = np.arctan2(moved[:, 1], moved[:, 0])
    drawn = np.stack((first, np.hypot(moved[:, 0], moved[:, 1]), moved[:, 2] - first))
    assert drawn.mean(axis=1) == pytest.approx(motion, abs=2e-3)
    assert drawn.std(axis=1) == pytest.approx(noise.deviations(motion), rel=0.01)
