"""From a room to a compiled scene."""

from collections.abc import Sequence
from math import cos, pi, sin
from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest

from tasks.errors import TaskError
from tasks.physics import Physics, Pose
from tasks.registry import task_model
from tasks.room_geometry.obstacles import Obstacles
from tasks.rooms.fence import FENCE_MARGIN, FENCE_THICKNESS
from tasks.rooms.limits import MAX_OBSTACLES
from tasks.rooms.room import Obstacle, Room, Shape, box, cylinder
from tasks.rooms.room_rule import RoomRule
from tasks.rooms.scene import compile_room
from tasks.scene.loading import MODELS, robot_physics

TURNED = (cos(0.4), 0.0, 0.0, sin(0.4))
TILTED = (cos(0.3), sin(0.3), 0.0, 0.0)
FENCE = ("fence_east", "fence_north", "fence_west", "fence_south")
TETRAHEDRON = ((0.3, 0.0, -0.2), (-0.3, 0.3, -0.2), (-0.3, -0.3, -0.2), (0.0, 0.0, 0.5))


def walls(half_x: float, half_y: float, x: float = 0.0, y: float = 0.0) -> tuple[Obstacle, ...]:
    """Four around a floor with its centre at x, y."""
    t = 0.05
    return (
        box(x, y + half_y + t, half_x + 2 * t, t, name="wall"),
        box(x, y - half_y - t, half_x + 2 * t, t, name="wall"),
        box(x + half_x + t, y, t, half_y, name="wall"),
        box(x - half_x - t, y, t, half_y, name="wall"),
    )


def names(model: mujoco.MjModel) -> set[str]:
    return {model.geom(geom).name for geom in range(model.ngeom)}


def robot_place(model: mujoco.MjModel) -> tuple[float, float]:
    x, y, _ = model.body("base").pos.tolist()
    return x, y


def physics_of(obstacles: Sequence[Obstacle]) -> Physics:
    return robot_physics(compile_room(Room(tuple(obstacles))), "a room")


# The fence ------------------------------------------------------------------------------------------------------------


def test_a_room_with_walls_gets_no_fence() -> None:
    assert not names(compile_room(Room((*walls(2.0, 1.5), cylinder(1.0, 0.0, 0.1))))) & set(FENCE)


@pytest.mark.parametrize(
    "obstacles",
    [
        (),
        (cylinder(3.0, 4.0, 0.2),),
        walls(2.0, 2.0)[:3],  # open to the west
        (*walls(0.4, 0.4), box(8.0, 0.0, 0.2, 0.2)),  # a closet, and much open floor beside it
        (*walls(0.4, 0.4), box(8.0, 0.0, 0.2, 0.2), box(8.0, 8.0, 0.2, 0.2), *walls(1.0, 1.0, 3.0, 8.0)),
    ],
)
def test_what_encloses_no_room_gets_a_fence_beyond_the_lasers_reach(obstacles: tuple[Obstacle, ...]) -> None:
    model = compile_room(Room(obstacles))
    assert set(FENCE) <= names(model)
    x, y = robot_place(model)
    fence = Obstacles.from_model(model)
    low, high = np.array(fence.low) + FENCE_THICKNESS, np.array(fence.high) - FENCE_THICKNESS
    for obstacle in obstacles:
        assert (np.array(obstacle.position[:2]) - low > FENCE_MARGIN).all()
        assert (high - obstacle.position[:2] > FENCE_MARGIN).all()
    assert low[0] < x < high[0]
    assert low[1] < y < high[1]
    RoomRule(model).draw(np.random.default_rng(0), np.zeros((0, 2)))


def test_pairs_beyond_the_obstacles_lie_within_the_fence() -> None:
    room = Room(walls(2.0, 2.0), pairs=((Pose(-9.0, 1.0, 0.0), (12.0, -3.0)),))
    model = compile_room(room)
    assert robot_place(model) == (-9.0, 1.0)
    assert Obstacles.from_model(model).high[0] == pytest.approx(12.0 + FENCE_MARGIN + 1.5 * FENCE_THICKNESS, abs=0.05)


@pytest.mark.parametrize(
    ("obstacle", "reach"),
    [
        (box(0.0, 0.0, 3.0, 0.1), (3.0, 0.1)),
        (box(0.0, 0.0, 3.0, 0.1, (cos(pi / 4), 0.0, 0.0, sin(pi / 4))), (0.1, 3.0)),
        (Obstacle(Shape.CYLINDER, (0.0, 0.0, 0.5), (0.2, 2.0)), (0.2, 0.2)),
        (Obstacle(Shape.CYLINDER, (0.0, 0.0, 0.2), (0.2, 2.0), (cos(pi / 4), sin(pi / 4), 0.0, 0.0)), (0.2, 2.0)),
        (Obstacle(Shape.SPHERE, (0.0, 0.0, 0.3), (0.7,)), (0.7, 0.7)),
        (Obstacle(Shape.HULL, (0.0, 0.0, 0.3), points=((2, 1, 0), (-2, 1, 0), (-2, -1, 0), (2, 0, 1))), (2.0, 1.0)),
    ],
)
def test_the_fence_keeps_its_margin_from_each_shape_as_it_is_turned(
    obstacle: Obstacle, reach: tuple[float, float]
) -> None:
    high = Obstacles.from_model(compile_room(Room((obstacle,)))).high
    assert np.array(high) == pytest.approx(np.array(reach) + FENCE_MARGIN + 1.5 * FENCE_THICKNESS)


def test_the_camera_above_sees_the_whole_room() -> None:
    model = compile_room(Room(walls(6.0, 2.0, 5.0, -3.0)))
    camera = model.camera("top")
    reach = (camera.pos[2] - 0.5) * np.tan(np.radians(model.cam_fovy[camera.id] / 2))
    assert camera.pos[:2] == pytest.approx([5.0, -3.0])
    assert 6.1 <= reach <= 8.0


# The robot ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shift", [(0.0, 0.0), (30.0, -7.0)])
def test_the_robot_stands_at_the_widest_place_wherever_the_origin_is(shift: tuple[float, float]) -> None:
    x, y = shift
    room = Room((*walls(3.0, 2.0, x, y), box(x - 1.0, y, 0.1, 1.99)))  # its eastern part is the wider one
    assert robot_place(compile_room(room)) == pytest.approx((x + 1.05, y), abs=0.15)


def test_the_robot_stands_in_the_midst_of_all_that_is_in_its_way() -> None:
    for name in ("clutter:3", "legs:3", "maze:3"):
        model = task_model(name)
        physics = robot_physics(model, name)
        assert physics.is_free(Pose(*robot_place(model), 0.0))


# Names ----------------------------------------------------------------------------------------------------------------


def test_names_are_unique_plain_and_none_of_the_robots() -> None:
    given = ["base", "left_wheel", "goal", "floor", "crate", "crate", "crate_1", "a b/ü", "", "", "x" * 200, "<&>"]
    model = compile_room(Room((*walls(9.0, 9.0), *(cylinder(i - 5.0, 3.0, 0.1, name) for i, name in enumerate(given)))))
    own = [model.geom(geom).name for geom in range(model.ngeom) if model.geom_bodyid[geom] == 0]
    assert len(set(own)) == len(own) == len(given) + 4 + 1  # the floor
    assert {"floor", "floor_1", "base_1", "crate_1", "crate_2", "crate_3", "a_b_ü", "x" * 60, "obstacle"} <= set(own)
    assert {"cylinder_1", "cylinder_2"} <= set(own)
    assert robot_physics(model, "a room").num_beams > 0


def test_a_movable_things_name_is_its_bodys_too() -> None:
    thing = Obstacle(Shape.BOX, (0.0, 1.0, 0.25), (0.2, 0.2, 0.25), mass=2.0, name="base")
    assert compile_room(Room((*walls(3.0, 3.0), thing))).body("base_1").mass == pytest.approx(2.0)


# Contacts and scans ---------------------------------------------------------------------------------------------------

SOLIDS = (
    box(2.0, 0.3, 0.3, 0.2, TURNED),
    cylinder(-1.5, 1.0, 0.25),
    Obstacle(Shape.SPHERE, (0.5, -1.8, 0.3), (0.4,)),
    Obstacle(Shape.CYLINDER, (-1.5, -1.5, 0.3), (0.15, 0.6), TILTED),
    Obstacle(Shape.HULL, (0.3, 1.8, 0.2), points=TETRAHEDRON),
)


def by_hand() -> Physics:
    """The same room as MJCF."""
    geoms, meshes = [], []
    for number, each in enumerate((*walls(3.0, 3.0), *SOLIDS)):
        place = f"pos='{' '.join(map(str, each.position))}' quat='{' '.join(map(str, each.quaternion))}'"
        if each.shape is Shape.HULL:
            meshes.append(f"<mesh name='m{number}' vertex='{' '.join(map(str, np.ravel(each.points)))}'/>")
            geoms.append(f"<geom class='obstacle' type='mesh' mesh='m{number}' {place}/>")
        else:
            size = " ".join(map(str, each.size))
            geoms.append(f"<geom class='obstacle' type='{each.shape}' size='{size}' {place}/>")
    xml = (
        f"<mujoco><include file='{MODELS}/rooms/common.xml'/><include file='{MODELS}/pioneer/pioneer.xml'/>"
        f"<asset>{''.join(meshes)}</asset><worldbody>{''.join(geoms)}</worldbody></mujoco>"
    )
    return robot_physics(mujoco.MjModel.from_xml_string(xml), "by hand")


def test_contacts_and_scans_are_those_of_a_scene_written_by_hand() -> None:
    scenes, rng = (physics_of((*walls(3.0, 3.0), *SOLIDS)), by_hand()), np.random.default_rng(0)
    crashes = 0
    for _ in range(60):
        x, y, yaw, linear, angular = rng.uniform((-2.6, -2.6, -pi, 0.1, -1.0), (2.6, 2.6, pi, 0.5, 1.0)).tolist()
        pose = Pose(x, y, yaw)
        found: list[Any] = []
        for physics in scenes:
            with physics.reset_context():
                physics.set_pose(pose)
            before = physics.ranges()
            physics.set_velocity_command(linear, angular)
            physics.step(40)
            found.append((physics.is_free(pose), physics.crashed(), before, physics.ranges(), physics.pose()))
        (free, crashed, *arrays), (other_free, other_crashed, *others) = found
        assert (free, crashed) == (other_free, other_crashed)
        for one, other in zip(arrays, others, strict=True):
            np.testing.assert_allclose(one, other, atol=1e-9)
        crashes += crashed
    assert 5 < crashes < 55


@pytest.mark.parametrize(("mass", "ends"), [(0.0, "crashed"), (0.5, "running")])
def test_a_fixed_box_is_a_crash_and_a_movable_one_is_pushed(mass: float, ends: str) -> None:
    thing = Obstacle(Shape.BOX, (1.0, 0.0, 0.2), (0.15, 0.15, 0.2), mass=mass, name="thing")
    physics = physics_of((*walls(4.0, 4.0), thing))
    with physics.reset_context():
        physics.set_pose(Pose(0.0, 0.0, 0.0))
    pushed, crashed = 0, False
    for _ in range(20):
        physics.set_velocity_command(0.4, 0.0)
        physics.step(40)
        pushed, crashed = pushed + physics.num_pushed(), crashed or physics.crashed()
    assert crashed == (ends == "crashed")
    assert bool(pushed) == (ends == "running")
    if mass:
        assert physics.named.data.xpos["thing", "x"] > 1.2


# Refused --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("obstacles", "sentence"),
    [
        ((box(0.0, 0.0, 0.1, 0.1),) * (MAX_OBSTACLES + 1), "20,001 obstacles are more than 20,000"),
        (walls(110.0, 110.0), r"a room of 220 × 220 m is larger than 40,000 m² or"),
        ((box(0.0, 0.0, 1e5, 0.1),), "a room of 200000 × 0 m is larger than 40,000 m² or longer than 500 m"),
        ((cylinder(0.0, 0.0, 0.1), cylinder(190.0, 190.0, 0.1)), r"a room of 202 × 202 m is larger"),
        ((cylinder(0.0, 0.0, 0.1), cylinder(1e4, 0.0, 0.1)), "a room 10000 m wide is larger than 500 m"),
        ((cylinder(float("nan"), 0.0, 0.1),), "the room .*(finite|nan)"),
        ((cylinder(0.0, 0.0, -1.0),), "the room cannot be compiled: .*size"),
        ((Obstacle(Shape.HULL, (0, 0, 0), points=((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0))),), "cannot be compiled"),
    ],
)
def test_rooms_beyond_the_limits_end_in_a_sentence(obstacles: tuple[Obstacle, ...], sentence: str) -> None:
    with pytest.raises(TaskError, match=sentence) as caught:
        compile_room(Room(obstacles))
    assert "\n" not in str(caught.value)


def test_a_closet_around_a_rooms_start_leaves_no_goal() -> None:
    closet = Room((*walls(4.0, 4.0), *walls(0.6, 0.6)), pairs=((Pose(0.0, 0.0, 0.0), (3.0, 0.0)),))
    with pytest.raises(TaskError, match="draws found no start and goal 1 m to 10 m apart"):
        RoomRule(compile_room(closet)).draw(np.random.default_rng(0), np.zeros((0, 2)))


def test_an_empty_room_is_an_open_floor() -> None:
    env = gymnasium.make("asddpg/Nav-v0", scene="open:0")
    _, info = env.reset(seed=0)
    assert info["distance"] >= 0.9
    env.close()
