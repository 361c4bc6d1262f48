"""Flat outlines: convex pieces that fill a polygon, walls along lines."""

import numpy as np
import pytest
import shapely

from tasks.physics import FloatArray
from tasks.rooms.flat.flat_shapes import prism, split_polygon, wall
from tasks.rooms.room import Room
from tests.support.room_clearances import room_clearances


def star(corners: int, inner: float) -> FloatArray:
    angles = np.linspace(0.0, 2 * np.pi, corners, endpoint=False)
    radii = np.where(np.arange(corners) % 2, inner, 2.0)
    return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)


COMB = np.array([(0, 0), (5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)], float)
STEPS = np.array([(0, 0), (1, 0), (2, 0), (3, 0), (3, 1), (2, 1), (2, 2), (1, 2), (1, 3), (0, 3), (0, 1.5)], float)


@pytest.mark.parametrize("corners", [COMB, STEPS, star(10, 0.8), star(60, 1.9), star(12, 0.05), star(7, 0.8)])
@pytest.mark.parametrize("way", [1, -1])
def test_convex_pieces_fill_a_polygon_without_overlap(corners: FloatArray, way: int) -> None:
    whole = shapely.Polygon(corners)
    pieces = [shapely.Polygon(piece) for piece in split_polygon(corners[::way])]
    assert sum(piece.area for piece in pieces) == pytest.approx(whole.area, rel=1e-6)
    assert shapely.symmetric_difference(shapely.union_all(pieces), whole).area == pytest.approx(0.0, abs=1e-5)
    assert all(piece.convex_hull.area == pytest.approx(piece.area) for piece in pieces)


def test_random_polygons_are_filled() -> None:
    rng = np.random.default_rng(0)
    for _ in range(100):
        angles = np.sort(rng.uniform(0.0, 2 * np.pi, rng.integers(4, 40)))
        radii = rng.uniform(0.3, 2.0, angles.size)
        corners = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)
        whole = shapely.Polygon(corners)
        if whole.is_valid:
            filled = shapely.union_all([shapely.Polygon(piece) for piece in split_polygon(corners)])
            assert shapely.symmetric_difference(filled, whole).area < 1e-4


def test_a_convex_polygon_stays_whole_and_turns_counter_clockwise() -> None:
    square = np.array([(0, 0), (0, 1), (0, 2), (2, 2), (2, 0), (0, 0)], float)  # clockwise, closed, a corner in line
    (piece,) = split_polygon(square)
    assert sorted(piece.tolist()) == [[0, 0], [0, 2], [2, 0], [2, 2]]
    assert shapely.Polygon(piece).exterior.is_ccw


@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0), (1, 0), (0, 1), (1, 1)],
        [(0, 0), (4, 0), (4, 4), (2, 0), (0, 4)],
        [(0, 0), (2, 0), (2, 2), (2, 1), (3, 1)],
        [(0, 0), (1, 1), (2, 2)],
    ],
)
def test_crossing_or_touching_edges_are_refused(corners: list[tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match="edges of the polygon cross"):
        split_polygon(np.array(corners, float))


@pytest.mark.parametrize("corners", [[(1, 1)], [(1, 1), (2, 2)], [(1, 1)] * 5, [(0, 0), (1e-3, 0), (0, 1e-3)]])
def test_a_polygon_without_area_has_no_pieces(corners: list[tuple[float, float]]) -> None:
    assert split_polygon(np.array(corners, float)) == []


def test_a_compiled_polygon_is_as_far_as_it_should_be() -> None:
    corners = COMB + np.array([3.0, -1.0])
    room = Room(tuple(prism(piece) for piece in split_polygon(corners)))
    points = np.random.default_rng(0).uniform((1.0, -3.0), (10.0, 4.0), (500, 2))
    expected = shapely.distance(shapely.Polygon(corners), shapely.points(points))
    assert room_clearances(room, points) == pytest.approx(expected, abs=1e-6)


def test_walls_along_a_line_close_at_its_corner() -> None:
    line = np.array([(0.0, 0.0), (3.0, 0.0), (3.0, 2.0)])
    room = Room((wall(line[0], line[1], 0.1), wall(line[1], line[2], 0.1)))
    points = [(1.0, 0.04), (1.0, -0.3), (3.04, -0.04), (2.0, 1.0), (3.0, 2.04), (3.0, 2.3)]
    assert room_clearances(room, points) == pytest.approx([0, 0.25, 0, 0.95, 0, 0.25])
