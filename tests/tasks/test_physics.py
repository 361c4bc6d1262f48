"""The physics against analysis."""

import math
from typing import Any

import mujoco
import numpy as np
import pytest

from tasks import constants
from tasks.evaluation_pairs import find_paths
from tasks.physics import Physics, Pose
from tasks.room_geometry.held_out import Pair
from tasks.room_geometry.obstacles import Obstacles, obstacle_names
from tasks.scene.loading import scene_path


def scene(name: str = "nav_empty") -> Any:
    return Physics.from_xml_path(str(scene_path(name)))


def place(physics: Any, pose: Pose) -> None:
    with physics.reset_context():
        physics.set_pose(pose)


def drive(physics: Any, linear: float, angular: float, seconds: float) -> None:
    physics.set_velocity_command(linear, angular)
    for _ in range(round(seconds / constants.CONTROL_TIMESTEP)):
        physics.step(round(constants.CONTROL_TIMESTEP / physics.timestep()))


def test_constants_are_those_of_the_compiled_robot() -> None:
    model = scene().model.ptr
    assert model.geom("left_wheel").size[0] == constants.WHEEL_RADIUS
    assert model.body("left_wheel").pos[1] - model.body("right_wheel").pos[1] == constants.TRACK
    assert model.actuator("left_wheel").ctrlrange[1] == constants.WHEEL_SPEED_LIMIT
    drive = scene().drive  # equal to the last bit: stored runs depend on it
    assert (drive.radius, drive.track) == (constants.WHEEL_RADIUS, constants.TRACK)
    assert drive.max_linear_velocity == constants.WHEEL_SPEED_LIMIT * constants.WHEEL_RADIUS
    assert drive.max_angular_velocity == constants.TURN_RATE_LIMIT
    cutoffs = {model.sensor(index).name: model.sensor_cutoff[index] for index in range(model.nsensor)}
    assert [name for name in cutoffs if name.startswith("range_")] == [f"range_{index:02d}" for index in range(40)]
    assert {cutoff for name, cutoff in cutoffs.items() if name.startswith("range_")} == {constants.MAX_RANGE}
    assert {cutoff for name, cutoff in cutoffs.items() if name.startswith("sonar_")} == {constants.MAX_SONAR_RANGE}


def test_straight_drive_covers_its_distance() -> None:
    physics = scene()
    place(physics, Pose(-3.0, 0.0, 0.0))
    drive(physics, 0.5, 0.0, 1.0)
    begin = physics.pose()
    drive(physics, 0.5, 0.0, 4.0)
    end = physics.pose()
    assert end.x - begin.x == pytest.approx(2.0, rel=0.01)
    assert abs(end.y - begin.y) < 0.01


def test_turn_on_the_spot_is_met_within_two_percent() -> None:
    physics = scene()
    place(physics, Pose(0.0, 0.0, 0.0))
    drive(physics, 0.0, math.pi / 3, 1.0)
    begin, turned, yaw = physics.pose(), 0.0, physics.pose().yaw
    for _ in range(30):
        drive(physics, 0.0, math.pi / 3, 0.2)
        turned += math.remainder(physics.pose().yaw - yaw, 2 * math.pi)
        yaw = physics.pose().yaw
    assert turned == pytest.approx(2 * math.pi, rel=0.02)
    assert math.dist(begin[:2], physics.pose()[:2]) < 0.02


def test_a_beam_that_meets_nothing_reads_the_maximum() -> None:
    physics = scene()
    physics.model.ptr.geom_group[:] = 0
    place(physics, Pose(100.0, 0.0, 0.0))  # outside the room
    assert physics.ranges().max() == constants.MAX_RANGE


def test_goal_in_robot_frame() -> None:
    physics = scene()
    place(physics, Pose(1.0, 2.0, math.pi / 2))
    physics.set_goal(0.0, 3.0)
    np.testing.assert_allclose(physics.readings().goal_in_robot_frame, [1.0, 1.0], atol=1e-12)
    assert physics.readings().goal_distance == pytest.approx(math.sqrt(2))


def test_resting_and_driving_freely_is_no_crash_and_a_wall_is_one() -> None:
    physics = scene()
    place(physics, Pose(2.5, 0.0, 0.0))
    drive(physics, 0.0, 0.0, 1.0)
    assert not physics.crashed()
    drive(physics, 0.5, 0.0, 1.0)
    assert not physics.crashed()
    drive(physics, 0.5, 0.0, 3.0)
    assert physics.crashed()


@pytest.mark.parametrize(("group", "crashes"), [(0, True), (1, False)])
def test_pushing_a_movable_thing_is_no_crash(group: int, crashes: bool) -> None:
    spec = mujoco.MjSpec.from_file(str(scene_path("nav_empty")))
    body = spec.worldbody.add_body(name="box", pos=[0.7, 0, 0.15])
    body.add_freejoint(name="box")
    body.add_geom(spec.find_default("movable"), name="box", size=[0.15, 0.15, 0.15], mass=0.5, group=group)
    from dm_control.mujoco import wrapper

    physics = Physics.from_model(wrapper.MjModel(spec.compile()))
    place(physics, Pose(0.0, 0.0, 0.0))
    crashed, pushed, touched = False, 0, set()
    for _ in range(10):
        drive(physics, 0.5, 0.0, 0.2)
        crashed |= physics.crashed()
        pushed = max(pushed, physics.num_pushed())
        touched.add(physics.touched())
    assert physics.data.ptr.body("box").xpos[0] > 0.9
    assert crashed is crashes
    assert pushed == (0 if crashes else 1)
    assert touched == {(), ("box",)}
    place(physics, Pose(-2.0, 0.0, 0.0))
    assert physics.touched() == ()


def test_the_wall_that_was_touched_is_named() -> None:
    physics = scene()
    names = []
    for x, yaw in ((3.5, 0.0), (-3.5, math.pi)):
        place(physics, Pose(x, 0.0, yaw))
        assert physics.touched() == ()
        drive(physics, 0.5, 0.0, 2.0)
        names.append(physics.touched())
    assert names == [("wall_east",), ("wall_west",)]


def test_obstacles_are_named_once_and_legs_by_their_furniture() -> None:
    assert obstacle_names(scene("nav_simple").model.ptr) == [
        "east", "north", "south", "wall_east", "wall_north", "wall_south", "wall_west", "west"
    ]  # fmt: skip
    model = scene("nav_gazebo").model.ptr
    names = obstacle_names(model)
    assert names == sorted(set(names))
    assert not [name for name in names if "leg" in name or name in ("floor", "base")]
    assert {"bin", "drum_3", "small_carton"} <= set(names)
    for name in names:
        assert Obstacles.from_model(model, [name]).outlines != Obstacles.from_model(model).outlines, name


def test_a_graze_within_a_control_step_is_seen() -> None:
    """A wall is in the way for 50 ms in the middle of a control step only."""
    physics = scene()
    place(physics, Pose(3.0, 0.0, 0.0))
    drive(physics, 0.5, 0.0, 1.0)
    moved = physics.model.ptr.geom("wall_east")
    physics.set_velocity_command(0.5, 0.0)
    physics.step(15)
    free = physics.crashed()
    moved.pos[0] = 3.6
    physics.step(10)
    touched = physics.crashed()
    moved.pos[0] = 4.05
    physics.step(15)
    assert (free, touched) == (False, True)


def test_clearance_is_the_distance_to_the_nearest_box() -> None:
    obstacles = Obstacles.from_model(scene("nav_simple").model.ptr)
    points = np.array([[0.0, 0.0], [0.0, 1.25], [3.0, 3.0], [1.0, 1.8]])
    # The bars end at y = ±1 and x = ±0.5, the walls stand at ±4; the last point is nearest to a corner.
    np.testing.assert_allclose(obstacles.clearance(points), [1.0, 0.0, 1.0, math.hypot(0.5, 0.3)], atol=1e-12)


def test_shortest_path_goes_straight_where_it_can_and_round_where_it_must() -> None:
    def length(name: str, goal: tuple[float, float]) -> float:
        (pair,) = find_paths([Pair(Pose(0.0, 0.0, 0.0), goal, math.inf)], scene(name).model.ptr, 0.3)
        return pair.shortest_path

    assert length("nav_empty", (3.0, 1.1)) == pytest.approx(math.hypot(3.0, 1.1) - 0.3, rel=0.02)
    # Round a corner of the east bar, 0.5 wide to x = 1.5…2.0, |y| ≤ 1, at the robot's 0.19 m.
    over_the_corner = math.hypot(1.5, 1.0) + 0.5 + math.hypot(1.0, 1.0) - 0.3
    assert over_the_corner < length("nav_simple", (3.0, 0.0)) < over_the_corner + 0.5
