"""Map, costmap and global plan of a robot, kept up to date: what every planning driver begins with."""

from dataclasses import dataclass

import numpy as np

from asddpg.planning.costmap import Costmap, Inflation
from asddpg.planning.global_planner import nearest_index, plan_path
from asddpg.planning.log_odds_map import LogOddsMap
from asddpg.planning.occupancy_grid import FloatArray, OccupancyGrid
from asddpg.planning.robot import Reading, Robot

RESOLUTION, MARGIN = 0.05, 8.0  # m; of a map that begins unknown, and its extent beyond the robot and the goal


@dataclass(frozen=True)
class NavigatorOptions:
    """What the navigator goes by.

    Attributes:
        uses_map: whether it begins with the robot's map, else with nothing known.
        uses_scans: whether it adds what the laser sees.
        inflation_radius: of the costmap, metres.
        cost_scaling: of the costmap, 1/m.
        replan_every: seconds from one global plan to the next.
    """

    uses_map: bool = True
    uses_scans: bool = True
    inflation_radius: float = 0.55
    cost_scaling: float = 10.0
    replan_every: float = 1.0


class Navigator:
    """Plans for one episode.

    Attributes:
        costmap: the present one.
        map: what the plan began with; of a room that was not known, what has been seen of it.
        path: to the goal, (n, 2), metres, map frame; None where the goal cannot be reached.
    """

    def __init__(self, robot: Robot, options: NavigatorOptions, first: Reading) -> None:
        """Begin with the reading of the episode's first observation."""
        self._robot, self._options = robot, options
        shape = robot.shape
        self._inflation = Inflation(shape.inscribed_radius, options.inflation_radius, options.cost_scaling)
        self._is_known = options.uses_map and robot.map is not None
        self.map = self._static = robot.map if self._is_known and robot.map is not None else _unknown_map(first)
        self._seen = LogOddsMap(self._static)
        self.costmap = Costmap.from_grid(self._static, self._inflation)
        self._steps_between_plans = max(1, round(options.replan_every / shape.control_timestep))
        self._steps, self._planned_for = 0, (np.nan, np.nan)
        self.path: FloatArray | None = None

    def update(self, reading: Reading) -> None:
        """Take the scan, and plan anew when it is time, when the goal has moved, or where the path is blocked."""
        if self._options.uses_scans:
            shape, before = self._robot.shape, self._seen.grid.occupied
            self._seen.insert(reading.pose, reading.ranges, shape.beams, shape.laser, shape.max_range)
            if (before != self._seen.grid.occupied).any():
                self._inflate()
        is_due = self._steps % self._steps_between_plans == 0 or reading.goal != self._planned_for
        if is_due and not self._is_known:
            self.map = self._seen.grid
        if is_due or self._is_blocked(reading):
            self.path = plan_path(self.costmap, reading.pose[:2], reading.goal)
            self._planned_for = reading.goal
        self._steps += 1

    def clear(self) -> None:
        """Forget what the laser saw."""
        self._seen.clear()
        self._inflate()

    def _inflate(self) -> None:
        self.costmap = Costmap.from_grid(self._static.with_obstacles(self._seen.grid.occupied), self._inflation)

    def _is_blocked(self, reading: Reading) -> bool:
        """Whether an obstacle lies on what is left of the path."""
        if self.path is None:  # the next plan comes when it is due
            return False
        rest = self.path[nearest_index(self.path, reading.pose[:2]) + 1 :]
        return bool(len(rest)) and not self.costmap.is_passable(rest).all()


def _unknown_map(reading: Reading) -> OccupancyGrid:
    corners = np.array([reading.pose[:2], reading.goal])
    low, high = corners.min(axis=0) - MARGIN, corners.max(axis=0) + MARGIN
    return OccupancyGrid.filled((low[0], low[1]), (high[0], high[1]), RESOLUTION)
