"""Walls out of cells: where they stand, and what is filled or left out."""

import numpy as np
import pytest

from tasks.errors import TaskError
from tasks.physics import Pose
from tasks.room_geometry.grid import BoolArray
from tasks.rooms.flat.cells import DEPTH, make_walls
from tasks.rooms.limits import MAX_WIDTH
from tasks.rooms.room import HEIGHT, Room
from tests.support.room_clearances import room_clearances


def walled(rows: int, columns: int) -> BoolArray:
    """Free cells with a wall of one cell around."""
    occupied = np.ones((rows, columns), dtype=bool)
    occupied[1:-1, 1:-1] = False
    return occupied


def test_rows_go_along_y_and_columns_along_x() -> None:
    occupied = walled(30, 50)
    occupied[10, 40] = True
    walls = make_walls(occupied, 0.1)
    assert len(walls) == 5
    inside = [(4.05, 1.05), (0.05, 1.0), (2.0, 2.95)]
    free = [(3.8, 1.05), (4.05, 1.3), (1.0, 1.5)]
    assert room_clearances(Room(walls), inside + free) == pytest.approx([0, 0, 0, 0.2, 0.2, 0.9])
    assert {wall.position[2] for wall in walls} == {HEIGHT / 2}


def test_a_turned_grid_turns_about_its_outer_corner() -> None:
    origin = Pose(-3.0, 2.0, 0.7)
    occupied = walled(30, 50)
    occupied[10, 40] = True
    points = np.random.default_rng(0).uniform((0.0, 0.0), (5.0, 3.0), (200, 2))
    cos, sin = np.cos(origin.yaw), np.sin(origin.yaw)
    turned = points @ np.array([[cos, sin], [-sin, cos]]) + [origin.x, origin.y]
    found = room_clearances(Room(make_walls(occupied, 0.1, origin)), turned)
    assert found == pytest.approx(room_clearances(Room(make_walls(occupied, 0.1)), points), abs=1e-9)


def test_closed_pockets_too_small_for_a_robot_are_filled() -> None:
    occupied = walled(60, 60)
    occupied[20:32, 20:32] = True
    occupied[22:25, 22:25] = False  # 0.15 m
    assert len(make_walls(occupied, 0.05)) == 5
    occupied[22:27, 22:27] = False  # 0.25 m
    assert len(make_walls(occupied, 0.05)) == 8


def test_solid_ground_far_from_the_floor_is_left_out() -> None:
    occupied = np.ones((400, 300), dtype=bool)
    occupied[200:260, 100:180] = False
    walls = make_walls(occupied, 0.05)
    assert len(walls) == 4
    corners = np.array([(w.position[0] + s * w.size[0], w.position[1] + s * w.size[1]) for w in walls for s in (-1, 1)])
    assert corners.min(axis=0) == pytest.approx([100 * 0.05 - DEPTH, 200 * 0.05 - DEPTH])
    assert corners.max(axis=0) == pytest.approx([180 * 0.05 + DEPTH, 260 * 0.05 + DEPTH])


def test_noise_beyond_the_walls_takes_no_boxes() -> None:
    occupied = np.random.default_rng(0).random((300, 300)) < 0.6
    occupied[90:210, 90:210] = True
    occupied[100:200, 100:200] = False
    assert len(make_walls(occupied, 0.05)) == 4


def test_free_cells_alone_are_a_room_without_walls() -> None:
    assert make_walls(np.zeros((20, 20), dtype=bool), 0.1) == ()


@pytest.mark.parametrize(
    ("occupied", "cell", "message"),
    [
        (np.ones((20, 20), dtype=bool), 0.1, "no free floor"),
        (np.indices((90, 90)).sum(axis=0) % 2 == 0, 0.1, "no free floor"),
        (walled(20, 20), MAX_WIDTH / 19, "m wide is larger than"),
        (np.indices((400, 400)).sum(axis=0) % 2 == 0, 0.5, "too rough"),
    ],
)
def test_grids_without_a_room_are_refused(occupied: BoolArray, cell: float, message: str) -> None:
    with pytest.raises(TaskError, match=message):
        make_walls(occupied, cell)
