"""Starts and goals from a room's geometry: against analysis, Shapely's geometry and MuJoCo's own contacts."""

from math import cos, hypot, pi, sin, sqrt
from typing import Any

import mujoco
import numpy as np
import pytest
import shapely

from tasks.constants import GOAL_RADIUS
from tasks.errors import TaskError
from tasks.evaluation_pairs import ROBOT_RADIUS
from tasks.physics import Physics, Pose
from tasks.registry import ROOM_TASKS, make_rule
from tasks.room_geometry.footprints import Footprint
from tasks.room_geometry.free_space import FreeSpace
from tasks.room_geometry.held_out import held_out_goals, held_out_pairs
from tasks.room_geometry.obstacles import Obstacles
from tasks.room_geometry.start_goal import HELD_OUT_MARGIN, MARGIN, FreeSpaceRule
from tasks.scene.loading import open_scene, scene_path
from tests.support.small_rooms import WALLS, VisibilityGraph, free_pieces, room

NO_GOALS = np.zeros((0, 2))
ROOMS = ("nav_gazebo", "nav_office")
RADIUS = 0.2722  # m: the deck's rear end, from the axis between the wheels

# Walls across the room at y = 1, with a gap in the middle.
GAP = '<geom name="left" type="box" pos="{west} 1 0.25" size="{half} 0.05 0.25"/>\
<geom name="right" type="box" pos="{east} 1 0.25" size="{half} 0.05 0.25"/>'


def gap(width: float) -> str:
    half = (3.0 - width / 2) / 2
    return GAP.format(half=half, west=-width / 2 - half, east=width / 2 + half)


def drawn(model: mujoco.MjModel, count: int = 300, **bounds: float) -> tuple[list[Pose], Any]:
    rule, rng = FreeSpaceRule(model, **bounds), np.random.default_rng(0)
    pairs = [rule.draw(rng, NO_GOALS) for _ in range(count)]
    return [start for start, _ in pairs], np.array([goal for _, goal in pairs])


def obstacles(things: str, assets: str = "") -> Obstacles:
    return Obstacles.from_model(room(things, assets=assets))


# Footprint ------------------------------------------------------------------------------------------------------------


def test_the_footprint_is_that_of_hull_and_wheels() -> None:
    footprint = Footprint.from_model(room())
    assert footprint.radius == pytest.approx(RADIUS, abs=0.005)
    assert footprint.half_width == pytest.approx(ROBOT_RADIUS, abs=0.005)
    assert footprint.height == pytest.approx(0.307, abs=0.005)


def test_the_footprint_does_not_depend_on_where_the_robot_stands() -> None:
    spec = mujoco.MjSpec.from_file(str(scene_path("nav_empty")))
    spec.body("base").pos, spec.body("base").quat = [2.0, 1.0, 0.0], [cos(0.4), 0.0, 0.0, sin(0.4)]
    found, expected = Footprint.from_model(spec.compile()), Footprint.from_model(room())
    np.testing.assert_allclose(found[1:], expected[1:], atol=2e-3)
    assert found.inscribed_radius == pytest.approx(expected.inscribed_radius, abs=2e-3)
    corners, border = np.array(found.outline), shapely.Polygon(expected.outline).exterior
    assert max(border.distance(shapely.Point(corner)) for corner in corners) < 2e-3


# Obstacles ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("thing", "distance"),
    [
        # From the origin to a thing around (2, 0).
        ('type="box" pos="2 0 0.2" size="0.3 0.1 0.2"', 1.7),
        ('type="box" pos="2 0 0.2" size="0.2 0.2 0.2" euler="0 0 45"', 2 - 0.2 * sqrt(2)),
        ('type="cylinder" pos="2 0 0.3" size="0.25 0.3"', 1.75),
        ('type="sphere" pos="2 0 0.2" size="0.25"', 1.75),
        # Only its lowest part, a disk at the height of the robot's top, is in the way.
        ('type="sphere" pos="2 0 0.507" size="0.25"', 2 - 0.15),
        ('type="ellipsoid" pos="2 0 0.2" size="0.4 0.1 0.15"', 1.6),
        ('type="capsule" pos="2 0 0.2" size="0.1 0.5" euler="0 90 0"', 1.4),
        ('type="capsule" pos="2 0 0.7" size="0.1 0.5"', 1.9),
        # A ramp: a box on edge, cut where the robot's top is.
        ('type="box" pos="2 0 0.507" size="0.2828427 0.5 0.2828427" euler="0 45 0"', 1.8),
        ('type="mesh" mesh="tetrahedron" pos="2 0 0.1"', 1.5),
        ('type="plane" pos="2 0 0" size="1 1 0.1" zaxis="-1 0 0"', 2.0),
    ],
)
def test_the_clearance_from_every_shape_is_the_analytic_one(thing: str, distance: float) -> None:
    tetrahedron = '<mesh name="tetrahedron" vertex="-0.5 0 0  0.5 -0.5 0  0.5 0.5 0  0 0 1"/>'
    things = f'<geom name="thing" {thing}/>'
    clearance = obstacles(things, tetrahedron).clearance([0.0, 0.0])
    # Round shapes may be taken as 1 % too large, never as too small.
    assert distance - 0.01 <= clearance <= distance + 1e-6


@pytest.mark.parametrize(
    "thing",
    [
        'type="box" pos="1 0 0.7" size="0.6 0.6 0.02"',
        'type="box" pos="1 0 -0.1" size="0.6 0.6 0.1"',
        'type="box" pos="1 0 0.2" size="0.3 0.3 0.2" contype="0" conaffinity="0"',
        'type="plane" pos="0 0 3" size="5 5 0.1" zaxis="0 0 -1"',
    ],
)
def test_geoms_above_below_or_without_contact_are_no_obstacles(thing: str) -> None:
    np.testing.assert_allclose(obstacles(f'<geom name="thing" {thing}/>').clearance([1.0, 0.0]), 2.0)


def test_under_a_table_the_floor_between_the_legs_is_free() -> None:
    legs = "".join(
        f'<geom name="leg{i}" type="cylinder" pos="{x} {y} 0.35" size="0.02 0.35"/>'
        for i, (x, y) in enumerate([(1, 1), (1, -1), (-1, 1), (-1, -1)])
    )
    table = obstacles(f'<geom name="top" type="box" pos="0 0 0.72" size="1.1 1.1 0.02"/>{legs}')
    assert table.clearance([0.0, 0.0]) == pytest.approx(sqrt(2) - 0.02, abs=1e-3)
    assert table.clearance([1.0, 1.0]) == 0.0


def test_movable_things_are_obstacles() -> None:
    geom = '<geom name="box" class="movable" size="0.2 0.2 0.2"/>'
    box = f'<body name="box" pos="1 1 0.2"><freejoint name="box"/>{geom}</body>'
    assert obstacles(box).clearance([1.0, 0.0]) == pytest.approx(0.8)


# Free space -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("width", "passes"), [(2 * (RADIUS + MARGIN) - 0.01, False), (0.76, True)])
def test_a_gap_is_passed_where_the_robot_can_turn_in_it(width: float, passes: bool) -> None:
    starts, goals = drawn(room(gap(width)))
    behind = np.concatenate([goals[:, 1], [start.y for start in starts]]) > 1.0
    assert behind.any() == passes


def test_a_closed_chamber_is_never_drawn_from_even_if_the_robot_stands_in_no_free_place() -> None:
    table = '<geom name="table" type="box" pos="0 0 0.2" size="0.2 0.2 0.2"/>'
    starts, goals = drawn(room(gap(0.3) + table))
    assert max(start.y for start in starts) < 0.7
    assert goals[:, 1].max() < 0.7


def test_episodes_take_place_around_the_robots_position_in_the_file() -> None:
    # A wall through the room, off the middle: the robot stands in the larger part.
    for side in (1, -1):
        wall = f'<geom name="wall" type="box" pos="{-0.8 * side} 0 0.25" size="0.05 3.1 0.25"/>'
        starts, goals = drawn(room(wall), max_path=4.0)
        assert min(side * start.x for start in starts) > -0.8
        assert np.min(side * goals[:, 0]) > -0.8


def test_the_outside_of_a_room_with_a_corner_cut_off_is_not_drawn_from() -> None:
    notch = """<geom name="cut_a" type="box" pos="1.5 0 0.25" size="1.5 0.05 0.25"/>
        <geom name="cut_b" type="box" pos="0 1.5 0.25" size="0.05 1.5 0.25"/>"""
    ell = WALLS.replace('pos="3.05 0 0.25" size="0.05 3.1 0.25"', 'pos="3.05 -1.5 0.25" size="0.05 1.6 0.25"')
    ell = ell.replace('pos="0 3.05 0.25" size="3.1 0.05 0.25"', 'pos="-1.5 3.05 0.25" size="1.6 0.05 0.25"')
    starts, goals = drawn(room(notch, ell))
    points = np.concatenate([goals, [start[:2] for start in starts]])
    assert not np.any((points > 0.0).all(axis=1))
    assert points[:, 0].max() > 2.0
    assert points[:, 1].max() > 2.0


def test_the_grid_follows_the_room_and_planes_are_walls() -> None:
    planes = "".join(
        f'<geom name="plane{i}" type="plane" pos="{10 + 4 * x} {4 * y} 0" size="5 5 0.1" zaxis="{-x} {-y} 0"/>'
        for i, (x, y) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1)])
    )
    _, goals = drawn(room(walls=planes))
    assert np.all(np.abs(goals - [10, 0]) <= 4 - RADIUS)
    assert np.ptp(goals, axis=0).min() > 6.5


def test_starts_have_all_headings_and_fill_the_room() -> None:
    starts, goals = drawn(room(), count=2000)
    for points in (goals, np.array([start[:2] for start in starts])):
        counts, _ = np.histogramdd(points, bins=4, range=[(-2.7, 2.7)] * 2)
        assert counts.min() > 60
    headings, _ = np.histogram([start.yaw for start in starts], bins=8, range=(-pi, pi))
    assert headings.min() > 180


@pytest.mark.parametrize("bounds", [(1.5, 8.0), (3.0, 4.0)])
def test_path_bounds_hold_by_a_visibility_graph(bounds: tuple[float, float]) -> None:
    model = room(gap(0.8) + '<geom name="post" type="cylinder" pos="1.5 -1.5 0.3" size="0.3 0.3"/>')
    (piece,) = free_pieces(model, RADIUS + MARGIN)
    starts, goals = drawn(model, 60, min_path=bounds[0], max_path=bounds[1])
    graph = VisibilityGraph(piece, bounds[1])
    lengths = [graph.length(start[:2], goal) for start, goal in zip(starts, goals, strict=True)]
    # The grid cuts no corner: its paths may be longer than the true ones by a cell a corner, never shorter.
    assert bounds[0] - 0.1 <= min(lengths)
    assert max(lengths) <= bounds[1]


def test_a_full_room_and_bounds_beyond_the_room_are_refused() -> None:
    with pytest.raises(TaskError, match="no free place: .* circle of 0.29 m"):
        FreeSpaceRule(room('<geom name="block" type="box" pos="0 0 0.2" size="2.9 2.9 0.2"/>'))
    with pytest.raises(TaskError, match="no start and goal with 50 to 60 m of free path .* longest is under [78]"):
        FreeSpaceRule(room(), 50.0, 60.0)
    with pytest.raises(TaskError, match="min_path must be"):
        FreeSpaceRule(room(), 3.0, 2.0)
    with pytest.raises(TaskError, match="no walls"):
        FreeSpaceRule(room(walls=""))
    axis = np.arange(-3, 3, 0.1)
    everywhere = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    rule = FreeSpaceRule(room())
    with pytest.raises(TaskError, match="every held-out goal"):
        rule.draw(np.random.default_rng(0), everywhere)


def test_environments_of_one_room_share_their_free_space() -> None:
    first, second = (FreeSpaceRule(room(gap(0.9)), 1.0, path) for path in (4.0, 5.0))
    assert first.free is second.free
    assert isinstance(first.free, FreeSpace)


# Registered rooms -----------------------------------------------------------------------------------------------------


def touches(physics: Any, pose: Pose) -> bool:
    """Whether the robot touches anything but the floor where it stands, by MuJoCo's collision detection."""
    model, data = physics.model.ptr, physics.data.ptr
    physics.set_pose(pose)
    mujoco.mj_fwdPosition(model, data)
    robot = np.asarray(model.body_rootid)[model.geom_bodyid] == model.body("base").id
    pairs = data.contact.geom
    between = robot[pairs[:, 0]] != robot[pairs[:, 1]]
    return bool(np.any(between & ~np.any(pairs == model.geom("floor").id, axis=1)))


@pytest.mark.parametrize("name", ROOMS)
def test_a_thousand_drawn_pairs_touch_nothing_and_lie_in_one_piece_of_shapelys_free_space(name: str) -> None:
    physics = Physics.from_xml_path(str(scene_path(name)))
    rule, rng = make_rule(name, physics.model.ptr), np.random.default_rng(3)
    pieces = shapely.MultiPolygon(free_pieces(physics.model.ptr, RADIUS))
    held_out = held_out_goals(name)
    for number in range(1000):
        start, goal = rule.draw(rng, held_out)
        headings = np.arange(0.0, 2 * pi, pi / 18).tolist() if number < 50 else [start.yaw]
        assert not any(touches(physics, start._replace(yaw=yaw)) for yaw in headings), "it cannot turn right round"
        assert not touches(physics, Pose(*goal, rng.uniform(-pi, pi)))
        holds = shapely.covers(shapely.get_parts(pieces), shapely.MultiPoint([start[:2], goal]))
        assert holds.sum() == 1
        assert np.min(np.hypot(*(held_out - goal).T)) > HELD_OUT_MARGIN


@pytest.mark.parametrize("name", [name for name in ROOM_TASKS if name not in ROOMS])
def test_a_thousand_goals_of_the_papers_rule_can_be_reached_from_the_origin(name: str) -> None:
    model = open_scene(scene_path(name)).model.ptr
    rule, rng = make_rule(name, model), np.random.default_rng(3)
    (piece,) = (piece for piece in free_pieces(model, RADIUS) if piece.covers(shapely.Point(0.0, 0.0)))
    things = shapely.MultiPolygon(free_pieces(model, 0.0))
    held_out = held_out_goals(name)
    for _ in range(1000):
        start, goal = rule.draw(rng, held_out)
        assert start == Pose(0.0, 0.0, 0.0)
        assert things.boundary.distance(shapely.Point(goal)) > 0.249
        assert things.covers(shapely.Point(goal))
        assert piece.distance(shapely.Point(goal)) < GOAL_RADIUS
        assert np.min(np.hypot(*(held_out - goal).T)) > HELD_OUT_MARGIN


PATHS = {"nav_gazebo": (1.5, 8.0), "nav_office": (3.0, 8.0)}  # m, bounds of their lengths


def make_graph(name: str) -> VisibilityGraph:
    pieces = free_pieces(open_scene(scene_path(name)).model.ptr, RADIUS + MARGIN)
    return VisibilityGraph(max(pieces, key=lambda piece: piece.area), PATHS[name][1])


@pytest.mark.slow
@pytest.mark.parametrize("name", ROOMS)
def test_stored_pairs_keep_the_bounds_by_a_visibility_graph(name: str) -> None:
    graph, (min_path, max_path) = make_graph(name), PATHS[name]
    for pair in held_out_pairs(name, "validation"):
        length = graph.length(pair.start[:2], pair.goal)
        assert min_path - 0.1 <= length <= max_path
        # For SPL the robot may pass gaps that its width fits in, and arrives at the goal's circle.
        assert hypot(pair.goal[0] - pair.start.x, pair.goal[1] - pair.start.y) - 0.36 <= pair.shortest_path <= length


@pytest.mark.long
@pytest.mark.parametrize("name", ROOMS)
def test_a_thousand_drawn_pairs_are_planned_by_a_visibility_graph_within_the_bounds(name: str) -> None:
    graph, (min_path, max_path) = make_graph(name), PATHS[name]
    rule, rng = make_rule(name, open_scene(scene_path(name)).model.ptr), np.random.default_rng(5)
    for _ in range(1000):
        start, goal = rule.draw(rng, NO_GOALS)
        assert min_path - 0.1 <= graph.length(start[:2], goal) <= max_path
