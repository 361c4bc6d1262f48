"""Rules for drawing starts and goals: the paper's, and one for any room, from its geometry."""

from math import pi
from typing import Protocol, Self

import mujoco
import numpy as np

from tasks.errors import TaskError
from tasks.physics import FloatArray, Pose
from tasks.room_geometry.footprints import Footprint
from tasks.room_geometry.free_space import free_space
from tasks.room_geometry.obstacles import Obstacles

HALF_ROOM = 4.0  # m; the paper's rooms are 8 x 8 m inside
WALL_MARGIN = 0.3  # m between goal and outer wall; released code
CENTRE_HALF_SIZE = 2.0  # m; no goal in |x| < 2 and |y| < 2 together; released code
OBSTACLE_MARGIN = 0.25  # m between goal and obstacles; released code

MARGIN = 0.02  # m around the robot's turning circle: a turn on the spot drifts by a centimetre
DEFAULT_MIN_PATH = 1.0  # m; well beyond the goal's radius, so that no episode ends at its start

HELD_OUT_MARGIN = 0.1  # m between a drawn goal and the goals of the stored evaluation sets
_MAX_DRAWS = 10_000


class PairRule(Protocol):
    """Draws starts and goals in one room."""

    @property
    def obstacles(self) -> Obstacles:
        """Of the room."""

    def draw(self, rng: np.random.Generator, held_out: FloatArray) -> tuple[Pose, tuple[float, float]]:
        """Draw a start and a goal.

        Args:
            rng: source of randomness.
            held_out: (n, 2) metres; the drawn goal keeps HELD_OUT_MARGIN from each.

        Returns:
            Pose of the base (m, rad) and goal (m), world frame.
        """


def is_held_out(goal: FloatArray | tuple[float, float], held_out: FloatArray) -> bool:
    """Whether a goal lies within HELD_OUT_MARGIN of one of the held-out goals, (n, 2), metres."""
    return bool(len(held_out)) and bool(np.min(np.sum((held_out - goal) ** 2, axis=1)) <= HELD_OUT_MARGIN**2)


class OriginRule:
    """The paper's rule: from the origin, looking along x, to a goal of the released code's rule."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Prepare a room; TaskError where it leaves no free place for a goal."""
        self.obstacles = Obstacles.from_model(model)
        self.draw(np.random.default_rng(0), np.zeros((0, 2)))

    def draw(self, rng: np.random.Generator, held_out: FloatArray) -> tuple[Pose, tuple[float, float]]:
        """Draw a goal uniformly from those that the rule allows; the start is always the origin."""
        reach = HALF_ROOM - WALL_MARGIN
        for _ in range(_MAX_DRAWS):
            goal = rng.uniform(-reach, reach, size=2)
            in_centre = bool(np.all(np.abs(goal) < CENTRE_HALF_SIZE))
            if in_centre or is_held_out(goal, held_out):
                continue
            if self.obstacles.clearance(goal) >= OBSTACLE_MARGIN:
                x, y = goal.tolist()
                return Pose(0.0, 0.0, 0.0), (x, y)
        raise TaskError(f"{_MAX_DRAWS} draws found no goal: the room leaves no free place for one by the paper's rule")


class FreeSpaceRule:
    """From any place where the robot can turn on the spot to any such place that it can drive to.

    The robot fits where its turning circle fits. A gap that only its width passes counts as closed: the robot cannot
    drive backwards, and would be trapped where it cannot turn.
    """

    def __init__(self, model: mujoco.MjModel, min_path: float = DEFAULT_MIN_PATH, max_path: float = np.inf) -> None:
        """Prepare a room.

        Args:
            model: compiled scene.
            min_path: metres, least length of the shortest path from start to goal on which the robot fits.
            max_path: metres, greatest length. Bounds less than half a metre apart may leave no pair: lengths are known
                to within some ten centimetres, and no pair is drawn whose length may lie outside.

        Raises:
            TaskError: no free place, no two of them as far apart as required, or invalid bounds.
        """
        if not 0.0 <= min_path < max_path:
            raise TaskError(f"min_path must be 0 or more and less than max_path, not {min_path} and {max_path}")
        home_x, home_y = model.qpos0[model.joint("base").qposadr[0] :][:2].tolist()
        radius = Footprint.from_model(model).radius + MARGIN
        self.obstacles = Obstacles.from_model(model)
        self.free = free_space(self.obstacles, radius, (home_x, home_y))
        self._first, self._last = self.free.goal_ranges(min_path, max_path)
        self._starts = np.flatnonzero(self._last > self._first)
        if not len(self._starts):
            raise TaskError(
                f"the room has no start and goal with {min_path:g} to {max_path:g} m of free path between them; "
                f"its longest is under {self.free.longest_path:.1f} m"
            )

    def __deepcopy__(self, _: object) -> Self:
        """It never changes: copies of an environment share its maps."""
        return self

    def draw(self, rng: np.random.Generator, held_out: FloatArray) -> tuple[Pose, tuple[float, float]]:
        """Draw a start uniformly from those that have goals, any heading, and a goal uniformly from its goals."""
        free = self.free
        for _ in range(_MAX_DRAWS):
            start = int(self._starts[rng.integers(len(self._starts))])
            goal = free.draw_place(free.goal_cell(start, int(rng.integers(self._first[start], self._last[start]))), rng)
            if not is_held_out(goal, held_out):
                return Pose(*free.draw_place(start, rng), rng.uniform(-pi, pi)), goal
        raise TaskError(
            f"none of {_MAX_DRAWS} goals drawn lies farther than {HELD_OUT_MARGIN} m from every held-out goal"
        )
