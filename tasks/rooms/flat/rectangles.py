"""Few rectangles that cover the occupied cells of a grid."""

import numpy as np
from scipy import ndimage

from tasks.room_geometry.grid import BoolArray, IntArray

_EIGHT_NEIGHBOURS = np.ones((3, 3))


def cover(occupied: BoolArray) -> IntArray:
    """Rectangles that cover each occupied cell once, and no other.

    Runs of cells, along the rows or along the columns, whichever takes fewer in a connected patch of cells, are merged
    with equal ones beside them.

    Args:
        occupied: (rows, columns).

    Returns:
        (rectangles, 4): first row, first column, and row and column after the last.
    """
    patches, count = ndimage.label(occupied, _EIGHT_NEIGHBOURS)
    along_rows, along_columns = _merge_runs(occupied), _merge_runs(occupied.T)[:, [1, 0, 3, 2]]
    patch_of_row, patch_of_column = (patches[found[:, 0], found[:, 1]] for found in (along_rows, along_columns))
    by_column = np.bincount(patch_of_column, minlength=count + 1) < np.bincount(patch_of_row, minlength=count + 1)
    return np.concatenate([along_rows[~by_column[patch_of_row]], along_columns[by_column[patch_of_column]]])


def _merge_runs(occupied: BoolArray) -> IntArray:
    edges = np.diff(np.pad(occupied, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    (rows, begins), (_, ends) = np.nonzero(edges == 1), np.nonzero(edges == -1)
    if not rows.size:
        return np.zeros((0, 4), dtype=np.intp)
    order = np.lexsort((rows, ends, begins))
    rows, begins, ends = rows[order], begins[order], ends[order]
    follows = (np.diff(begins) == 0) & (np.diff(ends) == 0) & (np.diff(rows) == 1)
    firsts, lasts = (np.flatnonzero(np.insert(~follows, place, [True])) for place in (0, follows.size))
    return np.stack([rows[firsts], begins[firsts], rows[lasts] + 1, ends[firsts]], axis=1)
