"""The map of a room: occupied where its obstacles are."""

import numpy as np
import pytest
import shapely

from asddpg.drivers.room_map import draw_room_map
from asddpg.planning.occupancy_grid import FREE, OCCUPIED, OccupancyGrid
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.room_geometry.obstacles import Obstacles
from tests.support.small_rooms import room

Box = tuple[float, float, float, float]  # centre x, y, width, height; m

# Measured from the bitmaps that the paper's authors released.
SIMPLE: tuple[Box, ...] = ((0, 1.25, 1, 0.5), (0, -1.25, 1, 0.5), (-1.75, 0, 0.5, 2), (1.75, 0, 0.5, 2))
COMPLEX: tuple[Box, ...] = (
    (0, 2, 1, 1), (-2.25, 2.25, 0.5, 0.5), (1.75, 2.25, 0.5, 0.5), (-1.5, 0.5, 1, 1), (1.25, 0.5, 0.5, 1),
    (1.75, 0.25, 0.5, 0.5), (-2.75, -0.77, 0.5, 0.47), (2.74, -0.77, 0.5, 0.47), (-1.25, -1.5, 0.5, 1),
    (1, -1.76, 2, 0.46), (1.23, -1.27, 0.46, 0.53), (-0.51, -2.87, 0.51, 0.25),
)  # fmt: skip


def centres(grid: OccupancyGrid) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return grid.to_points(np.moveaxis(np.indices(grid.shape), 0, -1))


@pytest.mark.parametrize(("task", "boxes"), [("nav_simple", SIMPLE), ("nav_complex", COMPLEX)])
def test_the_map_of_a_papers_room_has_its_boxes_and_walls(task: str, boxes: tuple[Box, ...]) -> None:
    environment = NavigationEnv(task)
    grid = draw_room_map(environment.obstacles)
    environment.close()
    assert set(np.unique(grid.cells).tolist()) == {FREE, OCCUPIED}
    solids = [shapely.box(x - w / 2, y - h / 2, x + w / 2, y + h / 2) for x, y, w, h in boxes]
    outside = shapely.box(-5, -5, 5, 5).difference(shapely.box(-4, -4, 4, 4))
    floor = shapely.union_all(solids)
    points = centres(grid)
    inside = (np.abs(points) < 4.0 + grid.resolution).all(axis=-1)  # up to the walls and a cell into them
    distances = shapely.distance(shapely.points(points), shapely.union_all([floor, outside]))
    cell = grid.resolution
    assert grid.occupied[inside & (distances == 0.0)].all()
    assert not grid.occupied[distances > cell].any()
    for solid in solids:
        assert grid.occupied[shapely.contains_xy(solid, points[..., 0], points[..., 1])].all()


def test_the_map_covers_the_room_and_a_cell_beyond() -> None:
    obstacles = Obstacles.from_model(room())
    assert (*obstacles.low, *obstacles.high) == pytest.approx((-3.1, -3.1, 3.1, 3.1))
    for resolution in (0.05, 0.08):
        grid = draw_room_map(obstacles, resolution)
        low = np.array(grid.origin)
        high = low + np.array(grid.shape[::-1]) * resolution
        assert grid.resolution == resolution
        assert (low <= -3.1 - resolution + 1e-9).all()
        assert (high >= 3.1 + resolution - 1e-9).all()
        assert ((low > -3.1 - 2.1 * resolution) & (high < 3.1 + 2.1 * resolution)).all()
        # Centres lie on multiples of a cell's side.
        np.testing.assert_allclose(low / resolution + 0.5, np.round(low / resolution + 0.5), atol=1e-9)


def test_a_cell_is_occupied_whose_centre_is_within_half_a_cell_of_a_box() -> None:
    # x from 0.51 to 0.99 and y from −0.03 to 0.03 m: centres at 0.5 and 1 are 0.01 away; at y ±0.05 they are 0.02 away
    box = '<geom name="box" type="box" pos="0.75 0 0.25" size="0.24 0.03 0.25"/>'
    grid = draw_room_map(Obstacles.from_model(room(box)))
    cells = grid.occupied & (np.abs(centres(grid)) < 2.0).all(axis=-1)
    found = centres(grid)[cells]
    assert found[:, 0].min() == pytest.approx(0.5)
    assert found[:, 0].max() == pytest.approx(1.0)
    assert sorted({round(float(y), 3) for y in found[:, 1]}) == [-0.05, 0.0, 0.05]
    assert len(found) == 11 * 3


def test_a_turned_box_and_a_cylinder_are_drawn_by_their_outlines() -> None:
    turned = '<geom name="turned" type="box" pos="1 1 0.25" euler="0 0 30" size="0.6 0.02 0.25"/>'
    round_one = '<geom name="round" type="cylinder" pos="-1 -1 0.25" size="0.4 0.25"/>'
    grid = draw_room_map(Obstacles.from_model(room(turned + round_one)))
    points = centres(grid)
    offset = points - 1.0
    along = offset @ (np.cos(np.pi / 6), np.sin(np.pi / 6))
    across = offset @ (-np.sin(np.pi / 6), np.cos(np.pi / 6))
    near = np.hypot(np.maximum(np.abs(along) - 0.6, 0.0), np.maximum(np.abs(across) - 0.02, 0.0))
    from_round = np.hypot(*np.moveaxis(points + 1.0, -1, 0)) - 0.4
    distances = np.minimum(near, from_round)
    inner = (np.abs(points) < 2.5).all(axis=-1)
    assert grid.occupied[inner & (distances < 0.02)].all()
    assert not grid.occupied[inner & (distances > 0.03)].any()


def test_nothing_above_the_robot_is_on_the_map() -> None:
    table = '<geom name="table" type="box" pos="1 1 1" size="0.5 0.5 0.1"/>'
    assert (draw_room_map(Obstacles.from_model(room(table))).cells == draw_room_map(
        Obstacles.from_model(room())).cells).all()  # fmt: skip


def test_an_obstacle_that_reaches_beyond_the_map_is_cut() -> None:
    square = ((-9.0, 0.88), (0.52, 0.88), (0.52, 9.0), (-9.0, 9.0))
    grid = draw_room_map(Obstacles((square, tuple((x + 50.0, y) for x, y in square)), (0.0, 0.0), (1.0, 1.0)), 0.1)
    points = centres(grid)
    expected = (points[..., 0] < 0.6) & (points[..., 1] > 0.8)  # centres at 0.55 and 0.85 are 0.03 m away
    assert (grid.occupied == expected).all()
