"""The robot of an environment, as planners see it: against the compiled model and the simulator's own readings."""

from collections.abc import Iterator

import numpy as np
import pytest
import shapely
from scipy.ndimage import binary_dilation

from asddpg.drivers.simulated_robot import SimulatedRobot, read_shape, with_room_map
from asddpg.planning.log_odds_map import LogOddsMap
from asddpg.planning.occupancy_grid import FloatArray
from tasks.constants import MAX_ANGULAR_VELOCITY, MAX_LINEAR_VELOCITY, MAX_RANGE
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.room_geometry.footprints import Footprint


@pytest.fixture(scope="module", params=["nav_complex", "nav_simple"])
def environment(request: pytest.FixtureRequest) -> Iterator[NavigationEnv]:
    environment = NavigationEnv(request.param)
    yield environment
    environment.close()


def ends(robot: SimulatedRobot, pose: tuple[float, float, float], ranges: FloatArray, beams: FloatArray) -> FloatArray:
    """Where beams end, (n, 2), map frame."""
    x, y, yaw = pose
    laser = complex(*robot.shape.laser) * np.exp(1j * yaw) + complex(x, y)
    points = laser + ranges * np.exp(1j * (yaw + beams))
    return np.stack([points.real, points.imag], axis=1)


def test_the_outline_contains_the_wheels_and_has_the_footprints_radius(environment: NavigationEnv) -> None:
    shape = read_shape(environment)
    outline = shapely.Polygon(shape.footprint)
    assert outline.is_valid
    assert outline.exterior.is_ccw
    assert outline.equals(outline.convex_hull) or outline.convex_hull.area == pytest.approx(outline.area, rel=1e-6)
    # Wheels of radius 0.0975 m on either side, 0.330 m apart.
    for y in (-0.165, 0.165):
        assert outline.contains(shapely.LineString([(-0.0975, y), (0.0974, y)]))
    radius = float(np.hypot(*shape.footprint.T).max())
    assert radius == pytest.approx(Footprint.from_model(environment.physics.model.ptr).radius, abs=1e-9)
    assert radius == pytest.approx(0.2722, abs=0.005)  # the deck's rear end


def test_the_inscribed_circle_touches_the_outline(environment: NavigationEnv) -> None:
    shape = read_shape(environment)
    distance = shapely.Point(0.0, 0.0).distance(shapely.Polygon(shape.footprint).exterior)
    assert shape.inscribed_radius == pytest.approx(distance, abs=1e-9)


def test_laser_limits_and_time_are_those_of_the_task(environment: NavigationEnv) -> None:
    shape = read_shape(environment)
    assert shape.laser == pytest.approx((0.1, 0.0), abs=1e-9)  # its sites in models/mjcf/pioneer/pioneer.xml
    assert shape.beams.shape == (40,)
    assert np.degrees(shape.beams[[0, -1]]) == pytest.approx((-120.0, 120.0))
    assert shape.max_range == MAX_RANGE
    assert shape.control_timestep == pytest.approx(0.2)
    assert shape.low == pytest.approx((0.0, -MAX_ANGULAR_VELOCITY))
    assert shape.high == pytest.approx((MAX_LINEAR_VELOCITY, MAX_ANGULAR_VELOCITY))


def test_other_limits_beams_and_times_are_read_too() -> None:
    environment = NavigationEnv("nav_simple", config={"control_timestep": 0.1, "laser": {"num_beams": 7}}, num_scans=2)
    shape = read_shape(environment)
    assert shape.beams == pytest.approx(np.radians((-120, -80, -40, 0, 40, 80, 120)))
    assert shape.control_timestep == 0.1
    observation, _ = environment.reset(seed=0)
    assert SimulatedRobot(environment, None).read(observation).ranges.shape == (7,)
    environment.close()


def test_a_reading_is_that_of_the_simulator(environment: NavigationEnv) -> None:
    robot = with_room_map(environment)
    observation, _ = environment.reset(seed=3, options={"start": (0.3, 3.0, -0.6), "goal": (-0.5, 3.2)})
    for _ in range(4):
        observation, _, _, _, info = environment.step(np.array([0.3, 0.5], dtype=np.float32))
    reading = robot.read(observation)
    assert reading.pose == info["pose"]
    assert reading.goal == (-0.5, 3.2)
    assert reading.velocity == pytest.approx((0.3, 0.5), abs=0.1)
    assert reading.velocity == pytest.approx(observation[-4:-2].tolist(), abs=1e-6)
    ranges = environment.physics.ranges()
    expected = np.where(ranges < MAX_RANGE, ranges, np.inf)
    np.testing.assert_allclose(reading.ranges, expected, atol=1e-6)
    assert reading.ranges.dtype == np.float64


def test_a_beam_without_a_return_reads_infinity() -> None:
    """From a corner the far one is 10 m away, and the laser sees 5.6 m."""
    environment = NavigationEnv("nav_simple")
    robot = with_room_map(environment)
    observation, _ = environment.reset(seed=0, options={"start": (-3.5, -3.5, 0.6), "goal": (0.0, 0.0)})
    found = robot.read(observation).ranges
    without = environment.physics.ranges() >= MAX_RANGE
    assert without.any()
    assert not without.all()
    assert (found[without] == np.inf).all()
    assert np.isfinite(found[~without]).all()
    environment.close()


def test_the_newest_of_the_scans_is_read(environment: NavigationEnv) -> None:
    robot = SimulatedRobot(environment, None)
    observation, _ = environment.reset(seed=3)
    changed = observation.copy()
    changed[:40], changed[40:-4] = -0.25, 0.1
    np.testing.assert_allclose(robot.read(changed).ranges, 1.4)  # 0.25 · 5.6 m


def test_a_robot_knows_its_room_or_nothing(environment: NavigationEnv) -> None:
    assert with_room_map(environment).map is not None
    assert SimulatedRobot(environment, None).map is None


def test_beams_end_on_the_maps_obstacles(environment: NavigationEnv) -> None:
    robot = with_room_map(environment)
    assert robot.map is not None
    near = binary_dilation(robot.map.occupied, np.ones((3, 3), dtype=bool))
    for start in ((0.0, 0.0, 0.0), (0.3, 3.0, -0.6), (-3.2, -3.2, 1.0)):
        observation, _ = environment.reset(seed=0, options={"start": start, "goal": (-0.5, 3.2)})
        reading = robot.read(observation)
        is_hit = np.isfinite(reading.ranges)
        cells = robot.map.to_cells(ends(robot, reading.pose, reading.ranges[is_hit], robot.shape.beams[is_hit]))
        assert near[tuple(cells.T)].all()


def test_a_map_of_scans_adds_nothing_beside_the_rooms_obstacles(environment: NavigationEnv) -> None:
    robot = with_room_map(environment)
    assert robot.map is not None
    found = LogOddsMap(robot.map)
    near = binary_dilation(robot.map.occupied, np.ones((3, 3), dtype=bool))
    for start in ((0.0, 0.0, 0.0), (0.3, 3.0, -0.6)):
        observation, _ = environment.reset(seed=0, options={"start": start, "goal": (-0.5, 3.2)})
        reading = robot.read(observation)
        found.insert(reading.pose, reading.ranges, robot.shape.beams, robot.shape.laser, robot.shape.max_range)
    assert found.grid.occupied.sum() > 20
    assert near[found.grid.occupied].all()
