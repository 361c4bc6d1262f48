"""Localisation in a room of segments, whose scans are computed exactly."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from asddpg.planning.amcl import AMCL, AMCLOptions
from asddpg.planning.likelihood_field import LikelihoodModel
from asddpg.planning.occupancy_grid import FREE, OCCUPIED, UNKNOWN, FloatArray, OccupancyGrid
from asddpg.planning.odometry import MotionNoise, OdometryErrors, WheelOdometry
from asddpg.planning.poses import compose, wrap_angle

ANGLES = np.radians(np.linspace(-120.0, 120.0, 40))
RANGE_MAX, STEP_SECONDS = 5.6, 0.2
LASER = (0.15, 0.0, 0.0)
WHEEL_RADIUS, TRACK = 0.0975, 0.33
ROOM = (6.0, 4.0)
BOXES = ((3.5, 1.0, 4.2, 1.8), (1.0, 2.5, 1.5, 4.0), (4.8, 3.2, 6.0, 4.0))  # low x, low y, high x, high y
START = np.array((1.8, 0.7, 0.1))
SPREAD = (0.1, 0.1, 0.05)
SPEED, CIRCLE = 0.3, 0.8  # m/s, m: the radius of the path, around (1.7, 1.5)
RECOVERY = AMCLOptions(alpha_slow=0.001, alpha_fast=0.1)
STILL = AMCLOptions(noise=MotionNoise(0.0, 0.0, 0.0, 0.0))  # no noise of motion


def rectangle(left: float, bottom: float, right: float, top: float) -> FloatArray:
    corners = np.array([(left, bottom), (right, bottom), (right, top), (left, top)])
    return np.stack((corners, np.roll(corners, -1, axis=0)), axis=1)


WALLS = np.concatenate([rectangle(0.0, 0.0, *ROOM), *(rectangle(*box) for box in BOXES)])


def cross(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def scan_from(robot: FloatArray) -> FloatArray:
    """Ranges (beams,) where the robot is at this pose."""
    laser = compose(robot, LASER)
    beams = np.stack((np.cos(laser[2] + ANGLES), np.sin(laser[2] + ANGLES)), axis=-1)[:, None]
    begin, along = WALLS[:, 0] - laser[:2], WALLS[:, 1] - WALLS[:, 0]
    distance = cross(begin, along) / cross(beams, along)
    share = cross(begin, beams) / cross(beams, along)
    meets = (distance > 0) & (share >= 0) & (share <= 1)
    return np.asarray(np.where(meets, distance, RANGE_MAX).min(axis=1))


def room_map() -> OccupancyGrid:
    grid = OccupancyGrid.filled((-0.225, -0.225), (ROOM[0] + 0.225, ROOM[1] + 0.225), 0.05, FREE)
    points = grid.to_points(np.moveaxis(np.indices(grid.shape), 0, -1))
    grid.cells[~is_inside(points)] = UNKNOWN
    for begin, end in WALLS:
        grid.cells[tuple(grid.to_cells(np.linspace(begin, end, 500)).T)] = OCCUPIED
    return grid


def is_inside(points: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Whether points (..., 2) are in the room and in no box: (...)."""
    inside = ((points > 0) & (points < ROOM)).all(axis=-1)
    for box in BOXES:
        inside &= ~((points > box[:2]) & (points < box[2:])).all(axis=-1)
    return np.asarray(inside)


GRID = room_map()


def localisation(seed: int = 0, options: AMCLOptions | None = None) -> AMCL:
    return AMCL(GRID, RANGE_MAX, np.random.default_rng(seed), LASER, options)


class Drive(NamedTuple):
    """Errors at each step, (steps,): of the estimate, metres and radians, and of odometry alone, metres."""

    distance: FloatArray
    yaw: FloatArray
    by_odometry: FloatArray


def drive(
    amcl: AMCL, steps: int, errors: OdometryErrors | None = None, carried: dict[int, FloatArray] | None = None
) -> Drive:
    """Drive along a circle from START; `carried` sets the robot down elsewhere before a step, unseen by the wheels."""
    odometry, robot, wheels = WheelOdometry(WHEEL_RADIUS, TRACK, 1000, errors), START, np.zeros(2)
    half_turn = 0.5 * SPEED * STEP_SECONDS / CIRCLE
    chord = 2 * CIRCLE * np.sin(half_turn)
    amcl.update(odometry.pose, scan_from(robot), ANGLES)
    found = []
    for step in range(steps):
        robot = (carried or {}).get(step, robot)
        robot = compose(robot, (chord * np.cos(half_turn), chord * np.sin(half_turn), 2 * half_turn))
        wheels += 2 * half_turn * (CIRCLE + TRACK * np.array((-0.5, 0.5))) / WHEEL_RADIUS
        amcl.update(odometry.update((wheels[0], wheels[1])), scan_from(robot), ANGLES)
        offset = amcl.pose() - robot
        by_odometry = compose(START, odometry.pose) - robot
        found.append((np.hypot(*offset[:2]), abs(wrap_angle(offset[2])), np.hypot(*by_odometry[:2])))
    return Drive(*np.array(found).T)


def test_tracking_without_errors() -> None:
    amcl = localisation()
    amcl.start_at(START, SPREAD)
    found = drive(amcl, 100)
    assert found.distance.max() < 0.07
    assert found.distance.mean() < 0.04
    assert found.yaw.max() < np.radians(4)


@pytest.mark.parametrize(
    ("errors", "limit"),
    [
        (OdometryErrors(left_radius=1.05, right_radius=1.05), 0.1),
        (OdometryErrors(track=1.05), 0.1),
        (OdometryErrors(right_radius=1.05), 0.12),
    ],
    ids=["both wheels", "track", "one wheel"],
)
def test_tracking_holds_against_5_percent_of_drift(errors: OdometryErrors, limit: float) -> None:
    amcl = localisation()
    amcl.start_at(START, SPREAD)
    found = drive(amcl, 120, errors)
    assert found.distance.max() < limit
    assert found.by_odometry.max() > 2 * limit  # alone it would not hold


@pytest.mark.parametrize("seed", [0, 1])
def test_global_localisation_finds_the_pose(seed: int) -> None:
    found = drive(localisation(seed, RECOVERY), 100)
    assert found.distance[0] > 0.5  # one scan does not do
    assert found.distance[-10:].max() < 0.3
    assert found.yaw[-10:].max() < np.radians(10)


def test_a_robot_that_was_carried_away_is_found_again() -> None:
    amcl = localisation(0, RECOVERY)
    amcl.start_at(START, SPREAD)
    found = drive(amcl, 150, carried={40: np.array((3.0, 3.0, 2.5))})
    assert found.distance[39] < 0.1
    assert found.distance[41] > 1.0
    assert found.distance[-10:].max() < 0.1


def test_share_of_random_particles_by_hand() -> None:
    amcl = localisation(0, replace(STILL, min_particles=5000, alpha_slow=0.01, alpha_fast=0.2))
    amcl.start_at(START, (0.0, 0.0, 0.0))
    good = LikelihoodModel(GRID, RANGE_MAX).weights(compose([START], LASER), scan_from(START), ANGLES)
    amcl.update((0.0, 0.0, 0.0), scan_from(START), ANGLES)
    amcl.update((0.25, 0.0, 0.0), [], [])  # a scan without echoes has the likelihood 1
    slow, fast = good + 0.01 * (1 - good), good + 0.2 * (1 - good)
    expected = compose(START, (0.25, 0.0, 0.0))
    is_random = np.abs(amcl.particles - expected).max(axis=1) > 1e-6
    assert is_random.mean() == pytest.approx(1 - fast / slow, abs=0.02)
    assert is_inside(amcl.particles[is_random, :2]).all()


def test_equal_seeds_give_equal_bits() -> None:
    first, second, other = localisation(3), localisation(3), localisation(4)
    for amcl in (first, second, other):
        drive(amcl, 20)
    np.testing.assert_array_equal(first.particles, second.particles)
    np.testing.assert_array_equal(first.weights, second.weights)
    assert first.pose().tolist() != other.pose().tolist()


def test_the_filter_waits_until_the_robot_has_moved_or_turned() -> None:
    amcl, scan = localisation(), scan_from(START)
    amcl.start_at(START, SPREAD)
    poses = [(0.0, 0.0, 0.0), (0.14, 0.13, 0.5), (0.15, 0.14, 0.5), (0.15, 0.14, 0.0), (0.15, 0.14, -0.03)]
    assert [amcl.update(pose, scan, ANGLES) for pose in poses] == [True, False, True, False, True]


def test_the_estimate_is_moved_by_odometry_between_updates() -> None:
    amcl, scan = localisation(), scan_from(START)
    amcl.start_at(START, SPREAD)
    amcl.update((5.0, 5.0, np.pi / 2), scan, ANGLES)
    before, particles = amcl.pose(), amcl.particles.copy()
    assert not amcl.update((5.0, 5.1, np.pi / 2 + 0.2), scan, ANGLES)
    moved = (0.1 * np.cos(before[2]), 0.1 * np.sin(before[2]), 0.2)
    np.testing.assert_allclose(amcl.pose(), np.add(before, moved))
    np.testing.assert_array_equal(amcl.particles, particles)


def test_particles_move_with_all_the_odometry_since_the_last_update() -> None:
    amcl = localisation(0, STILL)
    amcl.start_at((1.0, 1.0, 0.5), (0.0, 0.0, 0.0))
    for pose in ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.15, 0.05, 0.3), (0.2, 0.1, 0.4)):
        amcl.update(pose, [], [])
    np.testing.assert_allclose(amcl.particles, np.tile(compose((1.0, 1.0, 0.5), (0.2, 0.1, 0.4)), (100, 1)))


def test_every_second_update_resamples() -> None:
    amcl, scan = localisation(), scan_from(START)
    amcl.start_at(START, SPREAD)
    is_even = []
    for step in range(4):
        amcl.update((0.25 * step, 0.0, 0.0), scan, ANGLES)
        is_even.append(np.ptp(amcl.weights) < 1e-12)
        assert amcl.weights.sum() == pytest.approx(1.0)
    assert is_even == [False, True, False, True]


def resampled(options: AMCLOptions, pose: tuple[float, float, float], spread: tuple[float, float, float]) -> AMCL:
    """A filter after its first resampling, of equal weights."""
    amcl = localisation(0, options)
    amcl.start_at(pose, spread)
    for step in range(2):
        amcl.update((step, 0.0, 0.0), [], [])
    return amcl


def test_the_number_of_particles_follows_from_the_bins() -> None:
    assert len(resampled(STILL, (0.25, 0.25, 0.05), (0.0, 0.0, 0.0)).particles) == 100  # one bin
    few = replace(STILL, min_particles=20)
    # Two bins, either side of y = 0.5 after 1 m ahead, need 97: test_particle_bins.py.
    assert len(resampled(few, (0.25, 0.5 - np.sin(0.05), 0.05), (0.0, 0.01, 0.0)).particles) == 97
    assert len(resampled(AMCLOptions(), (3.0, 2.0, 0.0), (2.0, 2.0, 2.0)).particles) == 5000


def test_resampling_draws_by_weight() -> None:
    amcl = localisation(0, replace(STILL, min_particles=5000, resample_interval=1))
    amcl.particles = np.array([(1.0, 1.0, 0.0), (2.0, 1.0, 0.0), (3.0, 1.0, 0.0)])
    amcl.weights = np.array([0.7, 0.0, 0.3])
    amcl.update((0.0, 0.0, 0.0), [], [])
    assert {*amcl.particles[:, 0].tolist()} == {1.0, 3.0}
    assert (amcl.particles[:, 0] == 1.0).mean() == pytest.approx(0.7, abs=0.02)


def test_a_scan_multiplies_the_weights() -> None:
    amcl = localisation(0, STILL)
    amcl.particles = np.array([START, np.add(START, (0.0, 0.3, 0.0)), START])
    amcl.weights = np.array([0.2, 0.2, 0.6])
    amcl.update((0.0, 0.0, 0.0), scan_from(START), ANGLES)
    assert amcl.weights[2] == pytest.approx(3 * amcl.weights[0])
    assert amcl.weights[0] > 1.2 * amcl.weights[1]


def test_the_estimate_is_the_mean_of_the_heaviest_cluster() -> None:
    amcl = localisation()
    light = np.tile((5.0, 1.0, 0.0), (10, 1))
    heavy = np.array([(1.0, 1.0, np.pi - 0.1), (1.2, 1.0, -np.pi + 0.1)])
    amcl.particles = np.vstack((light, heavy))
    amcl.weights = np.array([*np.full(10, 0.04), 0.15, 0.45])
    np.testing.assert_allclose(amcl.pose()[:2], (1.15, 1.0))
    assert -np.pi < amcl.pose()[2] < -np.pi + 0.1
    assert amcl.covariance()[0, 0] == pytest.approx(0.4 * 3.85**2 + 0.15 * 0.15**2 + 0.45 * 0.05**2)


def test_a_start_has_the_spread_that_it_is_given() -> None:
    amcl = localisation()
    amcl.start_at((2.0, 1.0, 3.1), (0.3, 0.2, 0.1))
    np.testing.assert_allclose(amcl.covariance(), np.diag((0.09, 0.04, 0.01)), atol=0.004)
    assert len(amcl.particles) == 5000
    assert np.abs(amcl.particles[:, 2]).max() <= np.pi
    covariance = np.array([(0.09, 0.05, 0.0), (0.05, 0.04, 0.01), (0.0, 0.01, 0.02)])
    amcl.start_at((2.0, 1.0, 0.0), covariance)
    np.testing.assert_allclose(amcl.covariance(), covariance, atol=0.004)


def test_a_start_anywhere_covers_the_free_cells_evenly() -> None:
    amcl = localisation()
    amcl.start_anywhere()
    x, y, yaw = amcl.particles.T
    assert is_inside(amcl.particles[:, :2]).all()
    area = 6.0 * 4.0 - 0.7 * 0.8 - 0.5 * 1.5 - 1.2 * 0.8
    assert (x > 4.2).mean() == pytest.approx((1.8 * 4.0 - 1.2 * 0.8) / area, abs=0.03)
    assert (y > 2.5).mean() == pytest.approx((6.0 * 1.5 - 0.5 * 1.5 - 1.2 * 0.8) / area, abs=0.03)
    assert np.histogram(yaw, 4, (-np.pi, np.pi))[0] == pytest.approx(np.full(4, 1250), abs=120)


def test_a_map_without_free_cells_is_refused() -> None:
    with pytest.raises(ValueError, match="free cell"):
        AMCL(OccupancyGrid.filled((0.0, 0.0), (1.0, 1.0), 0.1), RANGE_MAX, np.random.default_rng(0))
