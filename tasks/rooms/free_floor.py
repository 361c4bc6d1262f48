"""Pieces of a room's free floor."""

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from tasks.physics import FloatArray
from tasks.room_geometry.grid import Grid, IntArray


class Pieces(NamedTuple):
    """Cells of a grid that join side by side.

    Attributes:
        labels: number of each cell's piece, from 1, and 0 where no floor is free: (rows, columns).
        enclosed: area of each piece, by number, m²; 0 where it reaches the grid's border.
        outside: area of all that do, m².
    """

    labels: IntArray
    enclosed: FloatArray
    outside: float


def label_pieces(grid: Grid) -> Pieces:
    """The pieces of a grid's free cells."""
    labels, count = ndimage.label(grid.free.reshape(grid.shape))
    areas: FloatArray = np.bincount(labels.ravel(), minlength=count + 1) * np.float64(grid.cell**2)
    at_border = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
    areas[0] = 0.0
    outside = float(areas[at_border].sum())
    areas[at_border] = 0.0
    return Pieces(labels, areas, outside)
