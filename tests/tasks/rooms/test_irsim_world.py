"""Worlds of IR-SIM as rooms."""

from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, translate

from tasks.errors import TaskError
from tasks.rooms.flat.irsim_world import LINE_THICKNESS, read_irsim
from tasks.rooms.room import Room, Shape
from tests.support.room_clearances import room_clearances

WORLD = """\
world: {height: 9, width: 11, offset: [-1, 2]}
robot:
  - {kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [1, 4, 0], goal: [9, 9, 0]}
obstacle:
  - {shape: {name: circle, radius: 0.7, center: [0.5, 0.2]}, state: [5, 5, 0.6]}
  - {shape: {name: rectangle, length: 1.5, width: 0.4}, state: [7, 5, 1]}
  - {shape: {name: linestring, vertices: [[0, 0], [1, 1], [1, 2]]}, state: [1, 7, 0.3]}
  - {shape: {name: polygon, vertices: [[0, 0], [2, 0], [2, 1.5], [1, 0.4], [0, 1.5]]}, state: [6, 7, 0.4]}
  - {shape: {name: polygon, vertices: [[0.2, 0.1], [1, 0.1], [0.5, 0.9]]}}
"""
LONG = [[np.cos(angle).item(), np.sin(angle).item()] for angle in np.linspace(0, 6, 200)]


def write(folder: Path, content: str | bytes) -> Path:
    path = folder / "world.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def read(folder: Path, obstacles: str) -> Room:
    return read_irsim(write(folder, f"obstacle:\n{obstacles}"))


def place(shape: shapely.Geometry, x: float, y: float, theta: float) -> shapely.Geometry:
    return translate(rotate(shape, theta, (0, 0), use_radians=True), x, y)


def test_shapes_stand_at_their_states_within_the_worlds_walls(tmp_path: Path) -> None:
    room = read_irsim(write(tmp_path, WORLD))
    shapes = [
        place(shapely.Point(0.5, 0.2).buffer(0.7, quad_segs=64), 5, 5, 0.6),
        place(shapely.box(-0.75, -0.2, 0.75, 0.2), 7, 5, 1),
        place(shapely.LineString([(0, 0), (1, 1), (1, 2)]).buffer(LINE_THICKNESS / 2), 1, 7, 0.3),
        place(shapely.Polygon([(0, 0), (2, 0), (2, 1.5), (1, 0.4), (0, 1.5)]), 6, 7, 0.4),
        place(shapely.Polygon([(0.2, 0.1), (1, 0.1), (0.5, 0.9)]), 1, 1, 0),  # IR-SIM's default state
        shapely.box(-1, 2, 10, 11).exterior,
    ]
    points = np.random.default_rng(0).uniform((-1, 2), (10, 11), (1000, 2))
    expected = shapely.distance(shapely.union_all(shapes), shapely.points(points))
    assert room_clearances(room, points) == pytest.approx(expected, abs=0.006)  # a line's corners are square
    assert room.omitted == ("robot: not taken, the task has a robot of its own",)
    assert room.pairs == ()


def test_a_world_is_10_m_wide_and_high_by_default(tmp_path: Path) -> None:
    found = room_clearances(read_irsim(write(tmp_path, "world:\n")), [(5, 5), (1, 5), (9.5, 5), (10.05, 5), (5, -0.05)])
    assert found == pytest.approx([5, 1, 0.5, 0, 0])


def test_the_last_state_and_shape_stand_for_the_rest(tmp_path: Path) -> None:
    room = read(
        tmp_path,
        """
  - number: 4
    distribution: {name: manual}
    state: [[4, 8], [3, 3, 1], [1, 5]]
    shape: [{name: circle, radius: 0.4}, {name: rectangle, length: 0.3, width: 0.6, wheelbase: 0.2}]
""",
    )
    rest = room.obstacles[4:]
    assert [obstacle.shape for obstacle in rest] == [Shape.CYLINDER, Shape.BOX, Shape.BOX, Shape.BOX]
    assert [obstacle.size[:2] for obstacle in rest] == [(0.4, 0.25)] + [(0.15, 0.3)] * 3
    places = [(4, 8), (3 + 0.1 * np.cos(1), 3 + 0.1 * np.sin(1)), (1.1, 5), (1.1, 5)]
    assert np.array([obstacle.position[:2] for obstacle in rest]) == pytest.approx(np.array(places))


def test_one_state_and_shape_stand_for_all(tmp_path: Path) -> None:
    room = read(tmp_path, "  {number: 3, state: [2, 3, 0], shape: {name: circle, radius: 0.5}}")
    assert [obstacle.position[:2] for obstacle in room.obstacles[4:]] == [(2, 3)] * 3


def test_a_file_of_several_simulators_is_read_by_its_part(tmp_path: Path) -> None:
    path = write(tmp_path, "other: {}\nirsim: {world: {width: 4, height: 3}}\n")
    assert room_clearances(read_irsim(path), [(2, 1)]) == pytest.approx([1])


@pytest.mark.parametrize(
    ("entry", "omitted"),
    [
        ("distribution: {name: random}, number: 5", "its places are drawn anew each time (distribution 'random')"),
        ("shape: {name: polygon, random_shape: true}", "its shape is drawn anew each time (random_shape)"),
        (
            "shape: {name: compound, parts: []}",
            "shape 'compound' is not read; circle, rectangle, polygon and linestring are",
        ),
        ("unobstructed: True", "robots drive through it (unobstructed)"),
        ("shape: {name: polygon, vertices: [[0, 0], [1, 0], [0, 1], [1, 1]]}", "edges of the polygon cross or touch"),
        ("shape: {name: polygon, vertices: [[0, 0], [1, 0]]}", "the polygon has no area"),
    ],
)
def test_what_is_left_out_is_named(tmp_path: Path, entry: str, omitted: str) -> None:
    room = read(tmp_path, f"  - {{{entry}}}\n  - {{state: [5, 5]}}\n")
    assert len(room.obstacles) == 5
    assert room.omitted == (f"obstacle 1: {omitted}",)


@pytest.mark.parametrize(
    ("entry", "omitted"),
    [
        ("kinematics: {name: omni}", "its motion (kinematics 'omni') is not taken, it stands where it begins"),
        ("mass: 2", "its mass is not taken, it stands fast"),
    ],
)
def test_what_moves_stands_still_and_is_named(tmp_path: Path, entry: str, omitted: str) -> None:
    room = read(tmp_path, f"  - {{{entry}, state: [5, 5]}}\n")
    assert len(room.obstacles) == 5
    assert room.omitted == (f"obstacle 1: {omitted}",)


def test_a_picture_of_the_world_and_unknown_keys_are_named(tmp_path: Path) -> None:
    room = read_irsim(write(tmp_path, "world: {obstacle_map: cave.png}\nlandmark: []\ngui: {}\n"))
    assert room.omitted == (
        "world: its obstacle_map is not read; a picture is a room of its own",
        "landmark: no such key is read",
    )


@pytest.mark.parametrize(
    "value", ["nan", ".nan", "inf", "-1", "0", "1e300", "1e-300", "wide", "[1]", "{}", "true", "''"]
)
@pytest.mark.parametrize("field", ["circle, radius", "rectangle, length", "rectangle, width"])
def test_invalid_sizes_are_refused(tmp_path: Path, field: str, value: str) -> None:
    with pytest.raises(TaskError, match=rf"obstacle 1: {field.split()[1]} must be (from|a number)"):
        read(tmp_path, f"  - {{shape: {{name: {field}: {value}}}}}")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "without names"),
        ("robot: {}", "has `world` or `obstacle`, and it has neither"),
        ("world: 3", "world must be a mapping"),
        ("world: {width: -3}", "the world's width must be from"),
        ("world: {offset: [1]}", "offset must be of numbers"),
        ("world: {offset: 3}", "offset must be of numbers"),
        ("obstacle: [3]", "obstacle 1 must be a mapping"),
        ("obstacle: text", "obstacle 1 must be a mapping"),
        ("obstacle: [{number: 1e9}]", "number must be from 0 to 20000"),
        ("obstacle: [{number: 20000}]", "obstacles are more than 20,000"),
        ("obstacle: [{state: here}]", "state must be"),
        ("obstacle: [{state: []}]", "state must not be empty"),
        ("obstacle: [{state: [1]}]", "state must be"),
        ("obstacle: [{state: [1, nan]}]", "state must be from"),
        ("obstacle: [{state: [1, [2]]}]", "state must be a number, not list"),
        ("obstacle: [{state: [1000, 1000]}]", "m wide is larger than 500 m"),
        ("obstacle: [{shape: circle}]", "shape must be a mapping"),
        ("obstacle: [{kinematics: omni}]", "kinematics must be a mapping"),
        ("obstacle: [{shape: {name: linestring}}]", "vertices must be 1 to 200 points"),
        ("obstacle: [{shape: {name: polygon, vertices: [1, 2]}}]", "vertices must be of numbers"),
        ("obstacle: [{shape: {name: polygon, vertices: " + str([[1, 2]] * 201) + "}}]", "vertices must be 1 to 200"),
        (f"v: &v {LONG}\nobstacle: [{{number: 300, shape: {{name: linestring, vertices: *v}}}}]", "more than 20,000"),
        (f"v: &v {LONG}\nobstacle: [{{number: 300, shape: {{name: polygon, vertices: *v}}}}]", "more than 50,000"),
        ("obstacle: &a [*a]", "not a YAML file that can be read"),
        ("obstacle: " + "[" * 20000, "not a YAML file that can be read"),
        ("obstacle: " + "{a: " * 5000, "not a YAML file that can be read"),
        ("world: {width: 1" + ":1" * 50000 + "}", "width must be a number"),
        ("world: {width: " + "9" * 10000 + "}", "width must be from"),
        (b"\xff\xfe\xff\xff", "not a YAML file that can be read"),
        (b"world: {name: \xe4}", "not a YAML file that can be read"),
        (b"#" * 500_001, "larger than 0.5 MB"),
    ],
)
def test_broken_files_end_in_a_sentence(tmp_path: Path, content: str | bytes, message: str) -> None:
    with pytest.raises(TaskError, match=message) as error:
        read_irsim(write(tmp_path, content))
    assert str(error.value).startswith(str(tmp_path / "world.yaml"))
    assert len(str(error.value)) < len(str(tmp_path)) + 200


@pytest.mark.parametrize("bomb", ["[{}]", "{{<<: [{}]}}"])
def test_aliases_of_aliases_take_no_memory(tmp_path: Path, bomb: str) -> None:
    lines = ["a0: &a0 {k: v}"]
    lines += [f"a{i + 1}: &a{i + 1} " + bomb.format(", ".join([f"*a{i}"] * 9)) for i in range(30)]
    room = read_irsim(write(tmp_path, "\n".join([*lines, "world: {}"])))
    assert len(room.omitted) == 31
