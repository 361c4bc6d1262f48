"""Open floor without walls."""

from math import cos, dist, hypot, pi, sin

import numpy as np

from tasks.physics import Pose
from tasks.rooms.generators.parts import turn
from tasks.rooms.room import Obstacle, Point, Room, box, cylinder

MOST_THINGS = 3
SIDE = (0.1, 1.5)  # m, of a thing
FAR = (0.8, 5.0)  # m, of a thing from the first start: in the laser's sight
APART = 0.7  # m between two things, and between a thing and a start or a goal: the robot turns between them
GOAL = (1.0, 8.0)  # m, from its start
PAIRS = 2
_TRIES = 10


def draw_open(rng: np.random.Generator) -> Room:
    """Draw up to three things around the origin, and starts there with goals 1 to 8 m away, any heading.

    The pairs belong to the room because a fence stands around a room without walls, 6 m from all that is in it. From
    places drawn anywhere inside the fence the robot would see it.
    """
    pairs = tuple(draw_pair(rng, GOAL) for _ in range(PAIRS))
    taken = [(0.0, 0.0, 0.0), *((*goal, 0.0) for _, goal in pairs)]
    things = []
    for _ in range(int(rng.integers(MOST_THINGS + 1))):
        half_x, half_y, is_round = rng.uniform(*SIDE) / 2, rng.uniform(*SIDE) / 2, rng.random() < 0.5
        reach = half_x if is_round else hypot(half_x, half_y)
        for _ in range(_TRIES):
            x, y = _draw_point(rng, *FAR)
            if all(dist((x, y), other[:2]) > reach + other[2] + APART for other in taken):
                taken.append((x, y, reach))
                things.append(_make_thing(x, y, half_x, half_y, None if is_round else rng.uniform(0.0, pi)))
                break
    return Room(tuple(things), pairs=pairs)


def draw_pair(rng: np.random.Generator, distances: tuple[float, float]) -> tuple[Pose, Point]:
    """A start at the origin, any heading, and a goal so many metres away, least and greatest."""
    return Pose(0.0, 0.0, rng.uniform(-pi, pi)), _draw_point(rng, *distances)


def _draw_point(rng: np.random.Generator, near: float, far: float) -> Point:
    """Any direction from the origin, any distance between the two, metres."""
    direction, distance = rng.uniform(-pi, pi), rng.uniform(near, far)
    return distance * cos(direction), distance * sin(direction)


def _make_thing(x: float, y: float, half_x: float, half_y: float, yaw: float | None) -> Obstacle:
    return cylinder(x, y, half_x) if yaw is None else box(x, y, half_x, half_y, turn(yaw))
