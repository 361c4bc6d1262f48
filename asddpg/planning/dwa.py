"""The dynamic window approach (Fox et al., 1997), as dwa_local_planner of ROS has it: samples, critics, the best one.

Every sample (v, ω) is simulated for `sim_time` along its arc. A critic gives each a cost, or rejects it; the
lowest sum wins. All samples are rated at once.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from asddpg.planning.costmap import INSCRIBED, LETHAL, Costmap
from asddpg.planning.global_planner import nearest_index
from asddpg.planning.grid_distances import grid_distances
from asddpg.planning.occupancy_grid import BoolArray, FloatArray, OccupancyGrid
from asddpg.planning.robot import Reading, RobotShape

OUTLINE_SPACING = 0.04  # m between the points of the footprint that are looked up, less than a cell


@dataclass(frozen=True)
class DWAOptions:
    """Constants, by default those of dwa_local_planner; docs/guides/planners.md says which differ, and why.

    Attributes:
        acceleration: of v, m/s², and of ω, rad/s².
        samples: of v and of ω.
        sim_time: seconds that a sample is simulated.
        spacing: between two simulated poses, metres and radians.
        path_bias: cost of a metre to the path.
        goal_bias: cost of a metre to the local goal.
        obstacle_scale: of the largest cost on the way.
        paddings: metres that the footprint is widened by on every side; a smaller one counts where the larger one
            leaves no sample, one below 0 where the robot stands in an obstacle's cell, or is stuck: it must get away.
        forward_point: metres to the point ahead of the base that alignment rates.
        least_translation: m/s; slower samples must turn.
        least_rotation: rad/s.
        window: half the side of the square around the robot in which distances are computed, metres: more than a sample
            reaches, since what ends outside is rejected.
        oscillation_distance: metres, and radians, after which the turn may change its sign again.
    """

    acceleration: tuple[float, float] = (2.5, 3.2)
    samples: tuple[int, int] = (8, 20)
    sim_time: float = 1.2
    spacing: tuple[float, float] = (0.05, 0.1)
    path_bias: float = 6.4
    goal_bias: float = 4.8
    obstacle_scale: float = 0.005
    paddings: tuple[float, ...] = (0.03, 0.0, -0.03)
    forward_point: float = 0.325
    least_translation: float = 0.1
    least_rotation: float = 0.4
    window: float = 1.2
    oscillation_distance: tuple[float, float] = (0.05, 0.2)


class DWA:
    """Follows a path around obstacles; one object an episode, since it remembers which way it turned."""

    def __init__(self, shape: RobotShape, options: DWAOptions | None = None) -> None:
        self._shape, self._options = shape, options or DWAOptions()
        self._outlines = [
            outline_points(pad(shape.footprint, padding), OUTLINE_SPACING) for padding in self._options.paddings
        ]
        self._footprint = outline_points(shape.footprint, OUTLINE_SPACING)
        # A turn gets away from obstacles too.
        smallest = pad(shape.footprint, min(self._options.paddings, default=0.0))
        self._turning_outline = outline_points(smallest, OUTLINE_SPACING)
        self._turn = 0  # sign of the turn that may not change now; 0 allows both
        self._turned_at = (0.0, 0.0, 0.0)

    def choose(
        self, reading: Reading, path: FloatArray, costmap: Costmap, is_stuck: bool = False
    ) -> tuple[float, float] | None:
        """The best v (m/s) and ω (rad/s); None where every sample is rejected.

        Args:
            reading: of the robot.
            path: to the goal, (n, 2), metres, map frame.
            costmap: of the room.
            is_stuck: whether there was no command lately, so that paddings below 0 count everywhere.
        """
        options = self._options
        sampled = sample_velocities(reading.velocity, self._shape, options)
        trajectories = simulate(reading.pose, sampled, options)
        self._forget_turn(reading.pose)
        others = self._oscillation_costs(sampled) + path_costs(trajectories, reading, path, costmap, options)
        here = np.array([[reading.pose]])
        for padding, outline in zip(options.paddings, self._outlines, strict=True):
            # Maps take obstacles for larger than they are, by half a cell and more, but it need not be by as much.
            if padding < 0.0 and not is_stuck and np.isfinite(obstacle_costs(here, self._footprint, costmap)[0]):
                break
            total = others + weigh(options.obstacle_scale, obstacle_costs(trajectories, outline, costmap))
            best = int(np.lexsort((np.abs(sampled[:, 1]), total))[0])  # of equal ones the straightest
            if np.isfinite(total[best]):
                v, omega = sampled[best].tolist()
                self._remember_turn(v, omega, reading.pose)
                return v, omega
        return None

    def can_turn(self, pose: tuple[float, float, float], angle: float, costmap: Costmap) -> bool:
        """Whether the robot at a pose can turn on the spot by an angle, rad, without touching an obstacle."""
        yaws = pose[2] + np.linspace(0.0, angle, 5)
        turning = np.stack([np.full(5, pose[0]), np.full(5, pose[1]), yaws], axis=1)[None]
        return bool(np.isfinite(obstacle_costs(turning, self._turning_outline, costmap)[0]))

    def _oscillation_costs(self, sampled: FloatArray) -> FloatArray:
        """Infinite for a turn of the other sign."""
        return np.where(sampled[:, 1] * self._turn < 0.0, np.inf, 0.0)

    def _remember_turn(self, v: float, omega: float, pose: tuple[float, float, float]) -> None:
        """A turn on the spot holds its direction until the robot has moved."""
        if v <= self._options.least_translation and omega and not self._turn:
            self._turn, self._turned_at = int(np.sign(omega)), pose

    def _forget_turn(self, pose: tuple[float, float, float]) -> None:
        x, y, yaw = np.subtract(pose, self._turned_at)
        distance, angle = self._options.oscillation_distance
        if np.hypot(x, y) > distance or abs(np.angle(np.exp(1j * yaw))) > angle:
            self._turn = 0


# Samples --------------------------------------------------------------------------------------------------------------


def sample_velocities(velocity: tuple[float, float], shape: RobotShape, options: DWAOptions) -> FloatArray:
    """The dynamic window's samples, (n, 2): what a control step's acceleration reaches, within the robot's limits.

    [max(low, v − a T), min(high, v + a T)] along each axis, evenly spaced, and 0 if it lies between.
    """
    axes = []
    for axis in (0, 1):
        low, high = shape.low[axis], shape.high[axis]
        present = min(max(velocity[axis], low), high)
        reach = options.acceleration[axis] * shape.control_timestep
        values = np.linspace(max(low, present - reach), min(high, present + reach), options.samples[axis])
        between = values[0] < 0.0 < values[-1]
        axes.append(np.union1d(values, [0.0]) if between else np.unique(values))
    sampled = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    is_slow = (np.abs(sampled[:, 0]) < options.least_translation) & (np.abs(sampled[:, 1]) < options.least_rotation)
    return sampled if is_slow.all() else sampled[~is_slow]


def simulate(pose: tuple[float, float, float], sampled: FloatArray, options: DWAOptions) -> FloatArray:
    """Each sample's arc for sim_time, in as many steps as the longest of them needs.

    Returns:
        x, y, yaw, map frame, (n, t, 3); the first is a step after the present pose.
    """
    reach = np.abs(sampled) * options.sim_time / options.spacing
    count = max(1, int(np.ceil(reach.max())))
    times = np.linspace(0.0, options.sim_time, count + 1)[1:]
    v, omega = sampled[:, :1], sampled[:, 1:]
    x, y, yaw = pose
    turned = omega * times  # [n, t]
    # A chord of the arc: v t sin(φ/2)/(φ/2) long, in the direction of half the turn φ.
    chord = v * times * np.sinc(turned / (2.0 * np.pi))
    direction = yaw + turned / 2.0
    return np.stack([x + chord * np.cos(direction), y + chord * np.sin(direction), yaw + turned], axis=-1)


# Critics: a cost for each sample, (n,); infinite for one that is rejected ---------------------------------------------


def weigh(scale: float, costs: FloatArray) -> FloatArray:
    """Scaled costs; by 0 too, what is rejected stays so."""
    return np.multiply(scale, costs, out=np.full_like(costs, np.inf), where=np.isfinite(costs))


def pad(footprint: FloatArray, padding: float) -> FloatArray:
    """The corners moved outward along x and along y, as costmap_2d pads a footprint: (n, 2), metres."""
    return footprint + padding * np.sign(np.round(footprint, 6))  # a corner on an axis stays on it


def outline_points(footprint: FloatArray, spacing: float) -> FloatArray:
    """Points on a polygon's sides, corners among them, no farther apart than `spacing`: (k, 2), metres."""
    sides = zip(footprint, np.roll(footprint, -1, axis=0), strict=True)
    parts = []
    for begin, end in sides:
        count = max(1, int(np.ceil(np.hypot(*(end - begin)) / spacing)))
        parts.append(begin + np.arange(count)[:, None] / count * (end - begin))
    return np.concatenate(parts)


def obstacle_costs(trajectories: FloatArray, outline: FloatArray, costmap: Costmap) -> FloatArray:
    """The largest cost of the axis's cells on the way; infinite where the outline's points meet an obstacle."""
    largest = costmap.cost_at(trajectories[..., :2])  # [n, t]
    worst: FloatArray = largest.max(axis=1).astype(np.float64)
    # Elsewhere the outline reaches no obstacle.
    near = np.argwhere(largest >= costmap.least_cost_within(float(np.hypot(*outline.T).max())))
    if len(near):
        x, y, yaw = (part[:, None] for part in trajectories[tuple(near.T)].T)
        cos, sin = np.cos(yaw), np.sin(yaw)
        points = np.stack([x + cos * outline[:, 0] - sin * outline[:, 1],
                           y + sin * outline[:, 0] + cos * outline[:, 1]], axis=-1)  # fmt: skip
        touches = (costmap.cost_at(points) >= LETHAL).any(axis=1)
        worst[near[touches, 0]] = np.inf
    return worst


def path_costs(
    trajectories: FloatArray, reading: Reading, path: FloatArray, costmap: Costmap, options: DWAOptions
) -> FloatArray:
    """Critics path, goal, alignment and goal_front: distances of the last pose, and of the point ahead of it."""
    window = _Window(costmap, reading.pose, options.window)
    rest = path[nearest_index(path, reading.pose[:2]) :]
    inside = window.contains(rest)
    # Up to where it first leaves the window.
    local = rest[: len(rest) if inside.all() else max(1, int(np.argmin(inside)))]
    ends = trajectories[:, -1]
    ahead = ends[:, :2] + options.forward_point * np.stack([np.cos(ends[:, 2]), np.sin(ends[:, 2])], axis=1)
    to_path, to_goal = window.distances(local), window.distances(local[-1:])
    from_path, from_goal = window.look_up(to_path, ends[:, :2]), window.look_up(to_goal, ends[:, :2])
    cost = weigh(options.path_bias, from_path) + weigh(options.goal_bias, from_goal)
    place = np.array(reading.pose[:2])
    if np.hypot(*(path[-1] - place)) > options.forward_point:
        to_local = local[-1] - place
        beyond = local[-1] + options.forward_point * to_local / max(float(np.hypot(*to_local)), 1e-9)
        if costmap.is_passable(beyond) and window.contains(beyond):
            to_goal = window.distances(beyond[None])
        # No sample is rejected for the point ahead: in an obstacle it counts as that much farther.
        cost += weigh(options.path_bias, window.look_up(to_path, ahead, from_path + options.forward_point))
        cost += weigh(options.goal_bias, window.look_up(to_goal, ahead, from_goal + options.forward_point))
    return cost


class _Window:
    """A square of a costmap around the robot, and distances in metres over its passable cells."""

    def __init__(self, costmap: Costmap, pose: tuple[float, float, float], half: float) -> None:
        grid, reach = costmap.grid, round(half / costmap.grid.resolution)
        rows, columns = grid.shape
        row, column = np.clip(grid.to_cells(pose[:2]), 0, (rows - 1, columns - 1)).tolist()  # a robot may be outside
        self._rows = slice(max(0, row - reach), min(rows, row + reach + 1))
        self._columns = slice(max(0, column - reach), min(columns, column + reach + 1))
        part = grid.cells[self._rows, self._columns]
        origin = (grid.origin[0] + self._columns.start * grid.resolution,
                  grid.origin[1] + self._rows.start * grid.resolution)  # fmt: skip
        self._grid = OccupancyGrid(part, grid.resolution, origin)
        self._blocked: BoolArray = costmap.costs[self._rows, self._columns] >= INSCRIBED

    def contains(self, points: FloatArray) -> BoolArray:
        """Whether points (n, 2) lie in the window, (n,)."""
        return self._grid.contains(self._grid.to_cells(points))

    def distances(self, seeds: FloatArray) -> FloatArray:
        """Metres from each cell to the nearest of the points (n, 2), along the grid."""
        rows, columns = self._grid.shape
        cells = np.clip(self._grid.to_cells(seeds), 0, (rows - 1, columns - 1))
        return grid_distances(self._blocked, cells) * self._grid.resolution

    def look_up(self, distances: FloatArray, points: FloatArray, unreached: npt.ArrayLike = np.inf) -> FloatArray:
        """Distances at points (n, 2); `unreached`, one or (n,), where no way leads, or outside."""
        cells = self._grid.to_cells(points)
        inside = self._grid.contains(cells)
        rows, columns = self._grid.shape
        row, column = np.clip(cells, 0, (rows - 1, columns - 1)).T
        found = np.where(inside, distances[row, column], np.inf)
        return np.where(np.isfinite(found), found, unreached)
