"""The rule of starts and goals in a room that is a file or is generated."""

from functools import cached_property
from math import pi

import mujoco
import numpy as np

from tasks.errors import TaskError
from tasks.physics import FloatArray, Pose
from tasks.room_geometry.footprints import Footprint
from tasks.room_geometry.free_space import CELL
from tasks.room_geometry.grid import BoolArray, Grid
from tasks.room_geometry.obstacles import Obstacles
from tasks.room_geometry.start_goal import DEFAULT_MIN_PATH, MARGIN, is_held_out
from tasks.rooms.free_floor import label_pieces

# m from start to goal as the crow flies: in its 40 s an episode drives 20 m at most, and ways have detours.
MAX_DISTANCE = 10.0
_MAX_DRAWS = 10_000


class RoomRule:
    """From any place where the robot can turn to any such place that it can drive to, 1 m to 10 m away.

    FreeSpaceRule measures paths, which takes a minute in a hall; here the straight line bounds them.

    Attributes:
        obstacles: of the room.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        """Prepare a room, by its compiled scene; its map is made with the first draw."""
        self._model = model
        self.obstacles = Obstacles.from_model(model)

    def __deepcopy__(self, _: object) -> "RoomRule":
        """It never changes: copies of an environment share its map."""
        return self

    @property
    def places(self) -> FloatArray:
        """Centres of the cells, CELL wide, of the floor: (n, 2), metres; TaskError without such a cell."""
        return self._places[0]

    @cached_property
    def _places(self) -> tuple[FloatArray, FloatArray]:
        """The same, and how far a place may lie from its centre along x and along y."""
        radius = Footprint.from_model(self._model).radius + MARGIN
        grid = Grid(self.obstacles, radius, CELL)
        cells = np.flatnonzero(self._floor(grid))
        return grid.points[cells], np.minimum(CELL / 2, (grid.clearance[cells] - radius) / np.sqrt(2))

    def _floor(self, grid: Grid) -> BoolArray:
        """The piece of free floor around the robot, or the largest that walls enclose."""
        pieces = label_pieces(grid)
        x, y, _ = self._model.body("base").pos.tolist()
        piece = pieces.labels.flat[grid.nearest((x, y))] or pieces.enclosed.argmax()
        if not piece:
            raise TaskError("the room leaves no free place where the robot can turn")
        return np.asarray(pieces.labels == piece)

    def draw(self, rng: np.random.Generator, held_out: FloatArray) -> tuple[Pose, tuple[float, float]]:
        """Draw a start and a goal; TaskError where the room leaves none."""
        for _ in range(_MAX_DRAWS):
            (start, goal), yaw = (self._draw_place(rng) for _ in range(2)), rng.uniform(-pi, pi)
            is_apart = DEFAULT_MIN_PATH <= np.hypot(goal[0] - start[0], goal[1] - start[1]) <= MAX_DISTANCE
            if is_apart and not is_held_out(goal, held_out):
                return Pose(*start, yaw), goal
        raise TaskError(
            f"{_MAX_DRAWS} draws found no start and goal {DEFAULT_MIN_PATH:g} m to {MAX_DISTANCE:g} m apart: the room "
            "leaves too little floor"
        )

    def _draw_place(self, rng: np.random.Generator) -> tuple[float, float]:
        centres, play = self._places
        cell = int(rng.integers(len(centres)))
        x, y = (centres[cell] + play[cell] * rng.uniform(-1.0, 1.0, 2)).tolist()
        return x, y
