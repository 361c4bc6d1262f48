"""The global planner: a cheap path over a costmap (navfn of ROS), and points along it."""

import numpy as np
from skimage.graph import MCP_Geometric

from asddpg.planning.costmap import INSCRIBED, Costmap
from asddpg.planning.occupancy_grid import FloatArray, IntArray

Point = tuple[float, float]

# Cost of a cell's width of way, navfn's: of a free cell, and of each unit of a costmap's cost beyond it.
NEUTRAL_COST, COST_FACTOR = 50.0, 0.8
GOAL_TOLERANCE = 0.3  # m; a goal that cannot be stood on is replaced by the nearest cell within this
# The path is averaged over so many metres so often, except where that would cost more and brings it nearer to an
# obstacle than the inscribed radius and a margin, metres.
SMOOTHING, PASSES, SMOOTHING_MARGIN = 0.5, 4, 0.1


def plan_path(costmap: Costmap, start: Point, goal: Point) -> FloatArray | None:
    """The cheapest 8-connected path, smoothed; None where none leads to within GOAL_TOLERANCE of the goal.

    A start in an impassable cell, which noise or a coarse cell brings about, is free to leave it.

    Args:
        costmap: where to drive.
        start: x and y, metres, map frame.
        goal: x and y, metres, map frame.

    Returns:
        Points (n, 2), metres, a cell or its diagonal apart before smoothing, from the passable cell at the start to the
        goal, or to the passable cell next to it.
    """
    grid = costmap.grid
    first, last = (_nearest_passable(costmap, point) for point in (start, goal))
    if first is None or last is None:
        return None
    costs = np.where(costmap.passable, NEUTRAL_COST + COST_FACTOR * costmap.costs, -1.0)  # negative is impassable
    search = MCP_Geometric(costs, fully_connected=True)
    totals, _ = search.find_costs([tuple(last)], [tuple(first)])
    if not np.isfinite(totals[tuple(first)]):
        return None
    cells = np.array(search.traceback(tuple(first)))[::-1]
    path = _smooth(costmap, grid.to_points(cells))
    return np.concatenate([path[:-1], [goal]]) if costmap.cost_at(goal) < INSCRIBED else path


def _nearest_passable(costmap: Costmap, point: Point) -> IntArray | None:
    """The passable cell nearest to a point, within GOAL_TOLERANCE, or None."""
    grid = costmap.grid
    reach = int(np.ceil(GOAL_TOLERANCE / grid.resolution))
    around = np.stack(np.meshgrid(*[np.arange(-reach, reach + 1)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    cells = grid.to_cells(point) + around
    cells = cells[grid.contains(cells)]
    cells = cells[costmap.passable[tuple(cells.T)]]
    distances = np.hypot(*(grid.to_points(cells) - point).T)
    if not len(cells) or distances.min() > GOAL_TOLERANCE:
        return None
    nearest: IntArray = cells[np.argmin(distances)]
    return nearest


def _smooth(costmap: Costmap, path: FloatArray) -> FloatArray:
    """Average the path along itself, PASSES times."""
    allowed = costmap.inflation.cost(costmap.inflation.inscribed_radius + SMOOTHING_MARGIN)
    index = np.arange(len(path))
    # Near its ends the window shrinks evenly: both keep their places.
    half = np.minimum(np.minimum(index, index[::-1]), round(SMOOTHING / 2 / costmap.grid.resolution))
    for _ in range(PASSES):
        sums = np.concatenate([np.zeros((1, 2)), np.cumsum(path, axis=0)])
        smoothed = (sums[index + half + 1] - sums[index - half]) / (2 * half + 1)[:, None]
        is_worse = costmap.cost_at(smoothed) > np.maximum(costmap.cost_at(path), allowed)
        path = np.where(is_worse[:, None], path, smoothed)
    return path


def nearest_index(path: FloatArray, position: Point) -> int:
    """The index of a path's point that is nearest to a position, metres."""
    return int(np.argmin(np.sum((path - position) ** 2, axis=1)))


def point_ahead(path: FloatArray, position: Point, distance: float) -> Point:
    """The point of a path (n, 2) a distance along it beyond the point nearest to a position, or its end; metres."""
    rest = path[nearest_index(path, position) :]
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(rest, axis=0).T))])
    x, y = (float(np.interp(distance, lengths, rest[:, axis])) for axis in (0, 1))
    return x, y
