"""Boxes and cylinders of different sizes, at any yaw, in a walled room."""

from math import cos, fsum, pi, sin, sqrt

import numpy as np

from tasks.rooms.generators.connected import draw_connected
from tasks.rooms.generators.parts import Rectangle, centred_floor, draw_place, enclose, turn
from tasks.rooms.room import Obstacle, Room, box, cylinder

SIDE = (6.0, 12.0)  # m, of the room
FILL = (0.05, 0.25)  # of the floor, things that overlap counted each
TYPICAL = (0.25, 0.9)  # m, side of a thing of the mean size
THINGS = (8, 100)  # least and most
SMALLEST = 0.2  # side of the smallest thing over the largest
SLENDER = 3.0  # longest side of a box over the other


def draw_clutter(rng: np.random.Generator) -> Room:
    """Draw a room of 6 to 12 m with things on 5 to 25 % of its floor."""
    return draw_connected(_sketch, rng)


def _sketch(rng: np.random.Generator) -> list[Obstacle]:
    width, depth = rng.uniform(*SIDE), rng.uniform(*SIDE)
    covered = width * depth * rng.uniform(*FILL)
    count = min(max(round(covered / rng.uniform(*TYPICAL) ** 2), THINGS[0]), THINGS[1])
    squares = [side * side for side in rng.uniform(SMALLEST, 1.0, count).tolist()]
    scale = covered / fsum(squares)
    floor = centred_floor(width, depth)
    things = [_draw_thing(rng, floor, scale * square) for square in squares]
    return [*enclose(floor), *things]


def _draw_thing(rng: np.random.Generator, floor: Rectangle, area: float) -> Obstacle:
    if rng.random() < 0.5:
        radius = sqrt(area / pi)
        return cylinder(*draw_place(rng, floor, radius, radius), radius)
    slender, yaw = sqrt(rng.uniform(1.0, SLENDER)), rng.uniform(0.0, pi)
    half_x, half_y = sqrt(area) / 2 * slender, sqrt(area) / 2 / slender
    c, s = abs(cos(yaw)), abs(sin(yaw))
    x, y = draw_place(rng, floor, c * half_x + s * half_y, s * half_x + c * half_y)
    return box(x, y, half_x, half_y, turn(yaw))
