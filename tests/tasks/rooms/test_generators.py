"""Generated rooms: what each generator promises, on many numbers, by Shapely and the compiled model."""

import os
import subprocess
import sys
from collections import Counter
from functools import cache
from hashlib import sha256
from itertools import pairwise
from math import dist, pi

import mujoco
import numpy as np
import pytest
import shapely
from shapely import affinity

from tasks.errors import TaskError
from tasks.evaluation_pairs import ROBOT_RADIUS
from tasks.physics import Pose
from tasks.room_geometry.footprints import Footprint
from tasks.room_geometry.obstacles import Obstacles
from tasks.room_geometry.start_goal import MARGIN, FreeSpaceRule
from tasks.rooms.generators import catalogue
from tasks.rooms.generators.catalogue import GENERATORS, generated_room
from tasks.rooms.generators.connected import MOST_OBSTACLES, TURNING_RADIUS, draw_connected, largest_share
from tasks.rooms.room import Obstacle, Room, Shape, box, cylinder
from tasks.rooms.scene import compile_room
from tasks.scene.loading import robot_physics
from tests.conftest import ROOT
from tests.support.small_rooms import free_pieces

WALLED = tuple(name for name in GENERATORS if name not in ("cylinders", "open", "bare"))
LASER_RANGE = 5.6  # m
many = pytest.mark.parametrize("number", range(20))


@cache
def compiled(name: str, number: int) -> mujoco.MjModel:
    return compile_room(generated_room(name, number))


@cache
def clearances(name: str, number: int) -> Obstacles:
    return Obstacles.from_model(compiled(name, number))


def shadow(obstacle: Obstacle) -> shapely.Polygon:
    x, y, _ = obstacle.position
    if obstacle.shape is Shape.CYLINDER:
        return shapely.Point(x, y).buffer(obstacle.size[0], quad_segs=32)
    assert obstacle.shape is Shape.BOX
    w, _, _, z = obstacle.quaternion
    half_x, half_y, _ = obstacle.size
    turned = affinity.rotate(shapely.box(-half_x, -half_y, half_x, half_y), 2 * np.arctan2(z, w), use_radians=True)
    return affinity.translate(turned, x, y)


def shadows(room: Room) -> shapely.Geometry:
    return shapely.union_all([shadow(obstacle) for obstacle in room.obstacles])


def walls(room: Room, axis: int) -> dict[float, list[tuple[float, float]]]:
    """Where the pieces of the walls along an axis begin and end, in order, by the wall's place on the other axis."""
    found: dict[float, list[tuple[float, float]]] = {}
    for wall in room.obstacles:
        along, across = wall.size[axis], wall.size[1 - axis]
        if wall.name == "wall" and across == 0.05 and along >= across:
            middle, at = wall.position[axis], wall.position[1 - axis]
            found.setdefault(round(at, 9), []).append((middle - along, middle + along))
    return {at: sorted(pieces) for at, pieces in found.items()}


def openings(room: Room) -> list[tuple[tuple[float, float], float]]:
    """Middles and widths of the gaps between pieces of the walls."""
    found = []
    for axis in (0, 1):
        for at, pieces in walls(room, axis).items():
            for (_, end), (begin, _) in pairwise(pieces):
                middle = (end + begin) / 2
                found.append(((middle, at) if axis == 0 else (at, middle), begin - end))
    return found


# A room by its number -------------------------------------------------------------------------------------------------

DIGESTS = """
from hashlib import sha256
from tasks.rooms.generators.catalogue import GENERATORS, generated_room
for name in sorted(GENERATORS):
    for number in (7, 0, 2**70):
        print(name, number, sha256(repr(generated_room(name, number)).encode()).hexdigest())
"""


def test_a_room_has_the_same_bits_in_another_process_and_order() -> None:
    environment = {**os.environ, "PYTHONHASHSEED": "1", "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", DIGESTS], env=environment, capture_output=True, text=True, check=True)
    for line in done.stdout.splitlines():
        name, number, digest = line.split()
        assert sha256(repr(generated_room(name, int(number))).encode()).hexdigest() == digest, line
    assert len(done.stdout.splitlines()) == 3 * len(GENERATORS)


def test_the_order_of_the_generators_and_new_ones_change_no_room(monkeypatch: pytest.MonkeyPatch) -> None:
    before = {name: generated_room(name, 3) for name in GENERATORS}
    others = {"new": GENERATORS["maze"], **dict(reversed(list(GENERATORS.items())))}
    monkeypatch.setattr(catalogue, "GENERATORS", others)
    assert {name: generated_room(name, 3) for name in before} == before
    assert generated_room("new", 3) != before["maze"]


@pytest.mark.parametrize("name", GENERATORS)
def test_rooms_of_different_numbers_differ(name: str) -> None:
    assert len({generated_room(name, number) for number in range(100)}) >= (70 if name == "open" else 100)


def test_an_unknown_name_or_a_negative_number_is_named() -> None:
    with pytest.raises(TaskError, match="'labyrinth'.*cylinders, clutter, legs, corridors, maze, rooms, open"):
        generated_room("labyrinth", 0)
    with pytest.raises(TaskError, match="0 or more, not -1"):
        generated_room("maze", -1)


# Every room -----------------------------------------------------------------------------------------------------------


def test_the_turning_circle_is_that_of_the_compiled_robot() -> None:
    assert Footprint.from_model(compiled("maze", 0)).radius + MARGIN == pytest.approx(TURNING_RADIUS, abs=1e-3)


@pytest.mark.parametrize("name", GENERATORS)
def test_rooms_have_no_more_obstacles_than_the_limit(name: str) -> None:
    counts = [len(generated_room(name, number).obstacles) for number in range(100)]
    assert max(counts) <= MOST_OBSTACLES == 250
    if name in WALLED:
        assert np.mean([20 <= count <= 80 for count in counts]) > 0.5


@pytest.mark.parametrize("name", GENERATORS)
@pytest.mark.parametrize("number", range(4))
def test_every_room_compiles_and_its_robot_touches_nothing(name: str, number: int) -> None:
    model = compiled(name, number)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon
    assert all("floor" in (model.geom(a).name, model.geom(b).name) for a, b in data.contact.geom)


@pytest.mark.parametrize("name", [*WALLED, "cylinders"])
@many
def test_the_largest_piece_of_the_floor_is_most_of_it(name: str, number: int) -> None:
    room = generated_room(name, number)
    covered = shadows(room)
    free = shapely.box(*covered.bounds).difference(covered.buffer(TURNING_RADIUS, quad_segs=16))
    areas = [piece.area for piece in shapely.get_parts(free)]
    assert max(areas) / sum(areas) >= 0.6


@pytest.mark.parametrize("name", WALLED)
def test_starts_and_goals_are_drawn_in_walled_rooms_without_a_fence(name: str) -> None:
    model = compiled(name, 0)
    assert not any("fence" in model.geom(geom).name for geom in range(model.ngeom))
    FreeSpaceRule(model).draw(np.random.default_rng(0), np.zeros((0, 2)))


@pytest.mark.parametrize("name", ["cylinders", "open"])
@many
def test_a_path_leads_from_each_start_to_its_goal(name: str, number: int) -> None:
    room = generated_room(name, number)
    assert room.pairs
    covered = shadows(room)
    # No way leads around the rows of cylinders.
    floor = shapely.box(-4.425, 0.0, -0.075, 14.0) if name == "cylinders" else shapely.box(-20, -20, 20, 20)
    pieces = shapely.get_parts(floor.difference(covered.buffer(0.24, quad_segs=16)))
    for start, goal in room.pairs:
        assert not covered.intersects(shapely.MultiPoint([start[:2], goal]).buffer(TURNING_RADIUS))
        [piece] = [piece for piece in pieces if piece.covers(shapely.Point(start[:2]))]
        assert piece.covers(shapely.Point(goal))


def test_a_floor_in_two_halves_is_drawn_again_and_again_and_then_named() -> None:
    halves = [box(0, 0, 0.05, 3), *(box(x, y, w, h) for x, y, w, h in
              [(0, 3, 3, 0.05), (0, -3, 3, 0.05), (3, 0, 0.05, 3), (-3, 0, 0.05, 3)])]  # fmt: skip
    assert largest_share(halves) == pytest.approx(0.5, abs=0.05)
    assert largest_share(halves[1:]) == 1.0
    with pytest.raises(TaskError, match="200 draws gave no room"):
        draw_connected(lambda _: halves, np.random.default_rng(0))
    with pytest.raises(TaskError, match="200 draws gave no room"):
        draw_connected(lambda _: halves[1:] * 63, np.random.default_rng(0))


def test_the_share_counts_each_shape_at_its_yaw() -> None:
    # A wall at 45 degrees from corner to corner, once short of a gap that the circle passes.
    frame = [box(0, 3, 3, 0.05), box(0, -3, 3, 0.05), box(3, 0, 0.05, 3), box(-3, 0, 0.05, 3)]
    yaw = (np.cos(pi / 8), 0.0, 0.0, np.sin(pi / 8))
    assert largest_share([*frame, box(0, 0, 4.2, 0.05, yaw)]) < 0.6
    assert largest_share([*frame, box(0, 0, 3.0, 0.05, yaw)]) > 0.99
    # A disc leaves the corners, a square of its size nothing.
    assert largest_share([*frame, cylinder(0, 0, 2.6)]) == pytest.approx(0.25)
    # From wall to wall, only if it is turned to the left.
    assert largest_share([*frame, box(-1, 1, 2.9, 0.05, yaw)]) == pytest.approx(0.85, abs=0.05)
    assert largest_share([*frame, *(cylinder(0, y, 0.2) for y in np.arange(-2.5, 3, 0.5))]) < 0.6
    assert largest_share([*frame, *(cylinder(0, y, 0.2) for y in np.arange(-2.5, 3, 1.25))]) > 0.9


# Each generator -------------------------------------------------------------------------------------------------------


@many
def test_a_field_of_cylinders_has_the_proportions_of_the_challenge(number: int) -> None:
    room = generated_room("cylinders", number)
    field = [thing for thing in room.obstacles if thing.shape is Shape.CYLINDER]
    assert {thing.size[0] for thing in field} == {0.075}
    columns = Counter(round(thing.position[0], 9) for thing in field)
    assert columns[-4.425] == columns[-0.075] == 30  # the two rows, whole
    assert min(columns) == -4.425
    assert max(columns) == -0.075
    cells = {(round((thing.position[0] + 4.425) / 0.15, 6), round(thing.position[1] / 0.15, 6)) for thing in field}
    assert len(cells) == len(field)
    assert all(value % 1 in (0.0, 0.5) for cell in cells for value in cell)
    south = shapely.box(-4.35, 0.1, -0.15, 5.1)
    assert shadows(room).intersection(south).area < 0.01  # 5 m of free floor
    assert shadows(room).bounds == pytest.approx((-4.5, 0.0, 0.0, 9.6))
    start, goal = room.pairs[0]
    assert (*start, *goal) == (-2.25, 3.0, pi / 2, -2.25, 13.0)
    assert dist(start[:2], goal) == 10.0


def test_fields_of_cylinders_are_from_sparse_to_dense() -> None:
    fills = [(len(generated_room("cylinders", number).obstacles) - 63) / (28 * 30) for number in range(100)]
    low, middle, high = np.percentile(fills, [5, 50, 95])
    assert low < 0.05 < middle < 0.12 < 0.16 < high  # six worlds of the challenge: 0.05 to 0.175


@many
def test_clutter_covers_5_to_25_percent_of_its_floor(number: int) -> None:
    room = generated_room("clutter", number)
    things = [shadow(thing) for thing in room.obstacles if thing.name != "wall"]
    west, south, east, north = shadows(room).bounds
    floor = shapely.box(west + 0.1, south + 0.1, east - 0.1, north - 0.1)
    sides = east - west - 0.2, north - south - 0.2
    assert 6.0 <= min(sides) <= max(sides) <= 12.0
    assert 0.05 * floor.area <= sum(thing.area for thing in things) * 1.001
    assert sum(thing.area for thing in things) <= 0.25 * floor.area
    assert floor.buffer(1e-6).covers(shapely.union_all(things))


def test_clutter_has_boxes_at_any_yaw_and_cylinders_of_many_sizes() -> None:
    things = [thing for number in range(20) for thing in generated_room("clutter", number).obstacles[4:]]
    boxes = [thing for thing in things if thing.shape is Shape.BOX]
    yaws = [2 * np.arctan2(thing.quaternion[3], thing.quaternion[0]) for thing in boxes]
    assert np.histogram(yaws, 6, (0, pi))[0].min() > len(boxes) / 12
    assert 0.4 < len(boxes) / len(things) < 0.6
    radii = [thing.size[0] for thing in things if thing.shape is Shape.CYLINDER]
    assert max(radii) > 5 * min(radii)


@many
def test_legs_are_4_to_5_cm_thick_and_stand_in_fours(number: int) -> None:
    legs = [thing for thing in generated_room("legs", number).obstacles if thing.name != "wall"]
    assert all(0.02 <= leg.size[0] <= 0.025 for leg in legs)
    assert all(leg.size[0] == leg.size[1] for leg in legs if leg.shape is Shape.BOX)
    for first in range(0, len(legs), 4):
        places = [leg.position[:2] for leg in legs[first : first + 4]]
        sides = [dist(a, b) for a, b in zip(places, [*places[1:], *places[:1]], strict=True)]
        assert sides[:2] == pytest.approx(sides[2:])
        assert dist(places[0], places[2]) == pytest.approx(dist(places[1], places[3]))  # a rectangle
        assert 0.3 < min(sides) <= max(sides) < 1.8
    room = shadows(generated_room("legs", number))
    west, south, east, north = room.bounds
    inside = shapely.box(west + 0.1, south + 0.1, east - 0.1, north - 0.1)
    assert inside.covers(shapely.union_all([shadow(leg) for leg in legs]))


def test_legs_are_round_and_square() -> None:
    shapes = Counter(thing.shape for number in range(20) for thing in generated_room("legs", number).obstacles[4:])
    assert min(shapes[Shape.BOX], shapes[Shape.CYLINDER]) > 0.3 * shapes.total()


@many
def test_doors_of_corridors_are_90_cm_wide_and_other_openings_are_corridors(number: int) -> None:
    obstacles = clearances("corridors", number)
    found = openings(generated_room("corridors", number))
    assert len([1 for _, width in found if width == pytest.approx(0.9)]) >= 4
    for middle, width in found:
        assert width == pytest.approx(0.9) or 1.2 <= width <= 2.4
        assert obstacles.clearance(middle) == pytest.approx(width / 2)


@many
def test_a_corridor_is_1_2_to_2_4_m_wide(number: int) -> None:
    west, _ = clearances("corridors", number).low
    middle = [(x, 0.0) for x in np.arange(west + 1.6, -west - 1.6, 0.05)]
    assert 0.6 - 1e-9 <= clearances("corridors", number).clearance(middle).min() <= 1.2


@many
def test_every_wall_between_rooms_has_one_door_of_90_to_120_cm(number: int) -> None:
    room, obstacles = generated_room("rooms", number), clearances("rooms", number)
    found = openings(room)
    inner = [at for axis in (0, 1) for at, pieces in walls(room, axis).items() if len(pieces) > 1]
    outer = [at for axis in (0, 1) for at, pieces in walls(room, axis).items() if len(pieces) == 1]
    assert len(found) == len(inner) >= 1
    assert len(outer) == 4
    for middle, width in found:
        assert 0.9 <= width <= 1.2
        assert obstacles.clearance(middle) == pytest.approx(width / 2)


@many
def test_all_rooms_behind_rooms_can_be_reached_through_their_doors(number: int) -> None:
    room = generated_room("rooms", number)
    walled = shadows(Room(tuple(thing for thing in room.obstacles if thing.name == "wall")))
    floor = shapely.box(*walled.bounds)
    assert len(shapely.get_parts(floor.difference(walled.buffer(0.44)))) == 1
    # With all doors closed: a tree of rooms.
    assert len(shapely.get_parts(floor.difference(walled.buffer(0.605)))) == len(openings(room)) + 1


@many
def test_all_cells_of_a_maze_can_be_reached_between_walls_of_10_cm(number: int) -> None:
    room = generated_room("maze", number)
    assert all(min(wall.size[:2]) == 0.05 for wall in room.obstacles)
    assert len(free_pieces(compiled("maze", number), 0.54)) == 1  # the narrowest cells are 1.1 m wide
    [cell] = {round(2 * max(wall.size[:2]) - 0.1, 9) for wall in room.obstacles[4:]}
    assert 1.2 <= cell <= 1.8
    west, south, east, north = shadows(room).bounds
    columns, rows = round((east - west - 0.1) / cell), round((north - south - 0.1) / cell)
    assert 4 <= min(columns, rows) <= max(columns, rows) <= 8
    closed = (columns - 1) * (rows - 1)  # by a spanning tree
    assert 0.5 * closed <= len(room.obstacles) - 4 <= closed


def test_some_mazes_are_trees_of_few_loops_and_some_have_many() -> None:
    loops = []
    for number in range(60):
        room = generated_room("maze", number)
        cell = 2 * max(room.obstacles[-1].size[:2]) - 0.1
        west, south, east, north = shadows(room).bounds
        closed = (round((east - west - 0.1) / cell) - 1) * (round((north - south - 0.1) / cell) - 1)
        loops.append(1 - (len(room.obstacles) - 4) / closed)
    assert min(loops) < 0.03
    assert max(loops) > 0.25


@many
def test_on_open_floor_up_to_three_things_are_in_sight_and_the_fence_is_not(number: int) -> None:
    room = generated_room("open", number)
    assert len(room.obstacles) <= 3
    assert all(0.05 <= half <= 0.75 for thing in room.obstacles for half in thing.size[: 1 + (thing.shape == "box")])
    model = compiled("open", number)
    fence = [geom for geom in range(model.ngeom) if "fence" in model.geom(geom).name]
    assert len(fence) == 4
    for start, goal in room.pairs:
        assert all(shadow(thing).distance(shapely.Point(start[:2])) < LASER_RANGE for thing in room.obstacles)
        assert 1.0 <= dist(start[:2], goal) <= 8.0
        for geom in fence:
            (x, y), (half_x, half_y) = model.geom_pos[geom][:2], model.geom_size[geom][:2]
            wall = shapely.box(x - half_x, y - half_y, x + half_x, y + half_y)
            assert wall.distance(shapely.LineString([start[:2], goal])) > LASER_RANGE


def test_open_floors_have_from_no_thing_to_three() -> None:
    counts = Counter(len(generated_room("open", number).obstacles) for number in range(200))
    assert all(counts[count] > 20 for count in range(4))
    headings = [start.yaw for number in range(200) for start, _ in generated_room("open", number).pairs]
    assert np.histogram(headings, 4, (-pi, pi))[0].min() > 60


def test_half_the_width_and_5_cm_is_the_clearance_of_fields() -> None:
    assert pytest.approx(0.24, abs=0.005) == ROBOT_RADIUS + 0.05


@many
def test_nothing_is_in_sight_of_a_bare_floor_between_start_and_goal(number: int) -> None:
    room = generated_room("bare", number)
    [(start, goal)] = room.pairs
    assert 1.5 <= np.hypot(*goal) <= 8.0
    physics = robot_physics(compiled("bare", number), "bare")
    for share in (0.0, 0.5, 1.0):
        with physics.reset_context():
            physics.set_pose(Pose(share * goal[0], share * goal[1], start.yaw))
        assert physics.ranges().min() == physics.max_range
