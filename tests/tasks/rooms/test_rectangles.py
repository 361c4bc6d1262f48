"""Rectangles that cover cells: all of them, once, and no other."""

import numpy as np
import pytest

from tasks.room_geometry.grid import IntArray
from tasks.rooms.flat.rectangles import cover


def count_covers(rectangles: IntArray, shape: tuple[int, int]) -> IntArray:
    """How many rectangles cover each cell."""
    counts = np.zeros(shape, dtype=np.intp)
    for top, left, bottom, right in rectangles:
        counts[top:bottom, left:right] += 1
    return counts


@pytest.mark.parametrize("density", [0.0, 0.05, 0.3, 0.6, 0.95, 1.0])
def test_rectangles_cover_each_occupied_cell_once_and_no_other(density: float) -> None:
    occupied = np.random.default_rng(round(100 * density)).random((37, 23)) < density
    assert np.array_equal(count_covers(cover(occupied), occupied.shape), occupied)


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1)])
def test_narrow_grids_are_covered(shape: tuple[int, int]) -> None:
    occupied = np.random.default_rng(0).random(shape) < 0.6
    assert np.array_equal(count_covers(cover(occupied), shape), occupied)


def test_a_filled_rectangle_is_one() -> None:
    occupied = np.zeros((8, 9), dtype=bool)
    occupied[2:5, 3:9] = True
    assert cover(occupied).tolist() == [[2, 3, 5, 9]]


def test_walls_around_a_room_are_four() -> None:
    occupied = np.ones((30, 40), dtype=bool)
    occupied[1:-1, 1:-1] = False
    assert len(cover(occupied)) == 4


def test_each_patch_takes_the_direction_that_needs_fewer() -> None:
    comb = np.zeros((6, 7), dtype=bool)
    comb[0], comb[:, ::3] = True, True  # a beam with three teeth: 4 by rows, 5 by columns
    assert len(cover(comb)) == len(cover(comb.T)) == 4
    apart = np.zeros((14, 14), dtype=bool)
    apart[:6, :7], apart[7:, 8:] = comb, comb.T
    assert len(cover(apart)) == 8


def test_many_cells_take_little_time() -> None:
    occupied = np.zeros((4000, 4000), dtype=bool)
    occupied[::40], occupied[:, ::40] = True, True
    assert len(cover(occupied)) == 100 + 100 * 100
