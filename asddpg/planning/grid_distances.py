"""Distances over a grid around obstacles, breadth first, as the DWA's map grids have them."""

import numpy as np

from asddpg.planning.occupancy_grid import BoolArray, FloatArray, IntArray


def grid_distances(blocked: BoolArray, seeds: IntArray) -> FloatArray:
    """Steps from each cell to the nearest seed, each to one of four neighbours, none into a blocked cell.

    Args:
        blocked: (rows, columns).
        seeds: (row, column) of cells, (n, 2); those that are blocked count none the less.

    Returns:
        float64 (rows, columns); inf where no way leads.
    """
    rows, columns = blocked.shape
    width = columns + 2
    # A rim of blocked cells spares the checks of the edges.
    steps = np.full((rows + 2, width), -1, dtype=np.int64)
    steps[1:-1, 1:-1] = np.where(blocked, -1, -2)  # −2: not reached yet
    flat = steps.ravel()
    front = np.unique((seeds[:, 0] + 1) * width + seeds[:, 1] + 1)
    flat[front] = 0
    neighbours = np.array([-width, -1, 1, width])
    count = 0
    while front.size:
        count += 1
        found = (front[:, None] + neighbours).ravel()
        found = found[flat[found] == -2]
        flat[found] = count
        front = _distinct(found, flat, count)
    inner = steps[1:-1, 1:-1]
    return np.where(inner < 0, np.inf, inner)


def _distinct(found: IntArray, flat: IntArray, count: int) -> IntArray:
    """Each cell once, without sorting: the last one of equal cells writes its place, and stays."""
    places = np.arange(found.size)
    flat[found] = places
    kept: IntArray = found[flat[found] == places]
    flat[found] = count
    return kept
