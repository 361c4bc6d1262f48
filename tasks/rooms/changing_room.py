"""A room for each episode: drawn by its number from a mixture of generators, written into the slots of one scene."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from math import pi
from typing import Any

import mujoco
import numpy as np

from tasks.errors import TaskError
from tasks.physics import FloatArray, Physics, Pose
from tasks.robots.names import PIONEER
from tasks.room_geometry.footprints import Footprint
from tasks.room_geometry.obstacles import Obstacles
from tasks.room_geometry.start_goal import MARGIN, PairRule
from tasks.rooms.fence import build_fence, find_extent, find_fence
from tasks.rooms.floor_cells import CELL, clearance, describe, divide_floor
from tasks.rooms.generators.catalogue import GENERATORS
from tasks.rooms.generators.connected import TURNING_RADIUS
from tasks.rooms.reading import find_room, is_room
from tasks.rooms.room import Obstacle, Point, Room
from tasks.rooms.scene import compile_room, place_camera
from tasks.rooms.slots import Slots

FIRST_NUMBER, LAST_NUMBER = 1000, 10**9 - 1  # of the rooms of a training; those below are for validation and test
OPEN = ("open", "bare")  # generators whose floor has no bounds
GENERATED = ("cylinders", "clutter", "legs", "corridors", "maze", "rooms", "open")
# By default: rooms with walls three times as often as others, for the detours that they ask for.
_WALLED = ("corridors", "maze", "rooms")
MIXTURE = (
    *(name for generator in GENERATED for name in [generator] * (3 if generator in _WALLED else 1)),
    *("nav_complex", "nav_gazebo", "nav_office"),
)
TRAINED_GOALS = (0.5, 10.0)  # m from start to goal as the crow flies
_MAX_DRAWS, _MAX_ROOMS = 200, 20


def is_open(name: str) -> bool:
    """Whether the floor of a generated room has no bounds."""
    return name.partition(":")[0] in OPEN


def turning_radius(robot: str, model: mujoco.MjModel) -> float:
    """What a robot needs for turning on the spot, and MARGIN; metres.

    Args:
        robot: its name.
        model: a compiled scene with it.
    """
    return TURNING_RADIUS if robot == PIONEER else Footprint.from_model(model).radius + MARGIN


class GeneratedRoomRule:
    """Starts and goals in a room that a generator drew, from its obstacles alone."""

    def __init__(
        self, room: Room, distances: tuple[float, float], has_own_pairs: bool, radius: float = TURNING_RADIUS
    ) -> None:
        """Prepare a room.

        Args:
            room: its obstacles.
            distances: metres from start to goal, least and greatest.
            has_own_pairs: whether starts and goals are the room's own.
            radius: metres around starts and goals that are free, and that ways between them leave free.
        """
        self._room, self._distances, self._radius = room, distances, radius
        self._has_own_pairs = has_own_pairs
        self._rows = describe(room.obstacles)

    @property
    def obstacles(self) -> Obstacles:
        """Of the room, as its compiled scene has them."""
        return _find_obstacles(self._room)

    def draw(self, rng: np.random.Generator, held_out: FloatArray) -> tuple[Pose, Point]:
        """Draw a start and a goal on the largest piece of floor; one of the room's own pairs on an open floor.

        Raises:
            TaskError: the room leaves none.
        """
        room = self._room
        if self._has_own_pairs:
            return room.pairs[int(rng.integers(len(room.pairs)))]
        places = tuple(each[:2] for pair in room.pairs for each in pair)
        cells = divide_floor(room.obstacles, self._radius, places).largest()
        for _ in range(_MAX_DRAWS if len(cells) else 0):
            x, y = self._draw_place(rng, cells)
            distances = np.hypot(cells[:, 0] - x, cells[:, 1] - y)
            near = cells[(distances >= self._distances[0] + CELL) & (distances <= self._distances[1] - CELL)]
            if not len(near):
                continue
            goal = self._draw_place(rng, near)
            if all(clearance(self._rows, *place) >= self._radius for place in ((x, y), goal)):
                return Pose(x, y, rng.uniform(-pi, pi)), goal
        raise TaskError("the room leaves no start and goal")

    @staticmethod
    def _draw_place(rng: np.random.Generator, cells: FloatArray) -> Point:
        x, y = (cells[int(rng.integers(len(cells)))] + rng.uniform(-CELL / 2, CELL / 2, 2)).tolist()
        return x, y


class ChangingRoom:
    """The room of the present episode.

    Attributes:
        name: of the room, such as cylinders:1234 or nav_office; empty before the first.
    """

    def __init__(
        self,
        names: Sequence[str],
        find_rule: Callable[[str], tuple[PairRule, FloatArray, Room]],
        radius: float = TURNING_RADIUS,
    ) -> None:
        """Mix rooms.

        Args:
            names: of generators and of tasks, each as likely as it is named.
            find_rule: of a task, its rule, the goals that no drawn one comes near, and its room.
            radius: as of GeneratedRoomRule.
        """
        self._names, self._find_rule, self._radius = names, find_rule, radius
        self.name = ""
        self._rule: PairRule | None = None
        self._held_out = np.zeros((0, 2))
        self._slots: Slots | None = None

    def __getstate__(self) -> dict[str, Any]:
        """A copy of an environment has slots of its own."""
        return self.__dict__ | {"_slots": None}

    @property
    def obstacles(self) -> Obstacles:
        """Of the present room."""
        if self._rule is None:
            raise TaskError("no room yet: the first begins with the first episode")
        return self._rule.obstacles

    def draw_name(self, rng: np.random.Generator) -> str:
        """A room's name from the mixture."""
        name = self._names[int(rng.integers(len(self._names)))]
        return f"{name}:{rng.integers(FIRST_NUMBER, LAST_NUMBER + 1)}" if name in GENERATORS else name

    def enter(self, physics: Physics, name: str) -> None:
        """Change the room; physics must be reset or restored afterwards.

        Raises:
            TaskError: there is no such room.
        """
        if is_room(name):
            room = find_room(name)
            self._rule = GeneratedRoomRule(room, TRAINED_GOALS, is_open(name), self._radius)
            self._held_out = np.zeros((0, 2))
        else:
            self._rule, self._held_out, room = self._find_rule(name)
        model = physics.model.ptr
        if self._slots is None or self._slots.model is not model:
            self._slots = Slots(model)
        corners = self._slots.fill(_standing(room))
        model.cam_pos[model.camera("top").id] = place_camera(*corners)
        self.name = name

    def enter_drawn(self, physics: Physics, rng: np.random.Generator) -> tuple[Pose, Point]:
        """Change to a room of the mixture, and draw a start and a goal in it.

        Some rooms, one of very many, leave no such pair, and some numbers give no room: then another is drawn.

        Raises:
            TaskError: no room of many has them.
        """
        for _ in range(_MAX_ROOMS):
            name = self.draw_name(rng)
            with suppress(TaskError):
                self.enter(physics, name)
                return self.draw(rng, self._held_out)
        raise TaskError(f"{_MAX_ROOMS} rooms leave the robot no start and goal; the last was {name}")

    def draw(self, rng: np.random.Generator, held_out: FloatArray) -> tuple[Pose, Point]:
        """Draw a start and a goal in the present room, away from the goals of its own evaluation sets."""
        assert self._rule is not None
        return self._rule.draw(rng, self._held_out)


@lru_cache(maxsize=64)  # as many rooms as a validation has, and more: each takes 20 ms
def _find_obstacles(room: Room) -> Obstacles:
    return Obstacles.from_model(compile_room(room))


def _standing(room: Room) -> tuple[Obstacle, ...]:
    """All that stands in the compiled scene of a room: a generated room with pairs of its own has a fence."""
    return room.obstacles + (build_fence(*find_fence(*find_extent(room))) if room.pairs else ())
