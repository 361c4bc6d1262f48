"""Tables and chairs, of which the laser sees the legs."""

from math import cos, dist, hypot, pi, sin

import numpy as np

from tasks.rooms.generators.connected import draw_connected
from tasks.rooms.generators.parts import Rectangle, centred_floor, draw_place, enclose, turn
from tasks.rooms.room import Obstacle, Point, Room, box, cylinder

SIDE = (5.0, 8.0)  # m, of the room
TABLES = (3, 9)  # least and most
LENGTH, WIDTH = (0.8, 1.8), (0.6, 0.9)  # m, of a table between the outer faces of its legs
MOST_CHAIRS = 3  # at a table
SEAT = (0.38, 0.46)  # m, of a chair, likewise
PUSHED = (0.05, 0.5)  # m from the table's edge to the middle of a chair
LEG = (0.04, 0.05)  # m thick
APART = 0.3  # m between two tables, at least
_TRIES = 8


def draw_legs(rng: np.random.Generator) -> Room:
    """Draw a room of 5 to 8 m with tables at any yaw and chairs about them; nothing stands above the floor but legs."""
    return draw_connected(_sketch, rng)


def _sketch(rng: np.random.Generator) -> list[Obstacle]:
    floor = centred_floor(rng.uniform(*SIDE), rng.uniform(*SIDE))
    legs, tables = enclose(floor), list[tuple[Point, float]]()
    for _ in range(int(rng.integers(TABLES[0], TABLES[1] + 1))):
        length, width = rng.uniform(*LENGTH), rng.uniform(*WIDTH)
        reach = hypot(length, width) / 2
        for _ in range(_TRIES):
            place = draw_place(rng, floor, reach, reach)
            if all(dist(place, other) > reach + far + APART for other, far in tables):
                tables.append((place, reach))
                legs += _draw_set(rng, floor, place, length, width)
                break
    return legs


def _draw_set(rng: np.random.Generator, floor: Rectangle, place: Point, length: float, width: float) -> list[Obstacle]:
    """A table and its chairs, as legs."""
    yaw = rng.uniform(0.0, pi)
    legs = _draw_legs(rng, place, yaw, length, width)
    for _ in range(int(rng.integers(MOST_CHAIRS + 1))):
        side = 1.0 if rng.random() < 0.5 else -1.0
        along, across = rng.uniform(-0.5, 0.5) * length, side * (width / 2 + rng.uniform(*PUSHED))
        x = place[0] + along * cos(yaw) - across * sin(yaw)
        y = place[1] + along * sin(yaw) + across * cos(yaw)
        seat = rng.uniform(*SEAT)
        if floor.west + seat < x < floor.east - seat and floor.south + seat < y < floor.north - seat:
            legs += _draw_legs(rng, (x, y), yaw + rng.uniform(-0.5, 0.5), seat, seat)
    return legs


def _draw_legs(rng: np.random.Generator, place: Point, yaw: float, length: float, width: float) -> list[Obstacle]:
    """The four legs of a thing, all round or all square."""
    half, is_round = rng.uniform(*LEG) / 2, rng.random() < 0.5
    legs = []
    for along, across in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        u, v = along * (length / 2 - half), across * (width / 2 - half)
        x, y = place[0] + u * cos(yaw) - v * sin(yaw), place[1] + u * sin(yaw) + v * cos(yaw)
        legs.append(cylinder(x, y, half, "leg") if is_round else box(x, y, half, half, turn(yaw), "leg"))
    return legs
