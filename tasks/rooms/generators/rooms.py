"""Rooms behind rooms: a rectangle, split again and again by walls with a door each."""

from math import dist

import numpy as np

from tasks.rooms.generators.connected import draw_connected
from tasks.rooms.generators.parts import KEPT_FREE, THICKNESS, Rectangle, build_wall, centred_floor, enclose, furnish
from tasks.rooms.room import Obstacle, Point, Room

SIDE = (7.0, 13.0)  # m, of the rectangle
DOOR = (0.9, 1.2)  # m wide
LEAST = 2.0  # m, side of a room
LARGEST = 6.0  # m; a room with a longer side is always split
KEPT = 0.25  # chance that a smaller one is not
JAMB = 0.2  # m from a door to the wall's end, at least
FURNITURE = 3  # pieces in a room, at most
_TRIES = 8  # at a wall that ends in no door


def draw_rooms(rng: np.random.Generator) -> Room:
    """Draw a rectangle of 7 to 13 m, divided into furnished rooms of 2 m or more a side."""
    return draw_connected(_sketch, rng)


def _sketch(rng: np.random.Generator) -> list[Obstacle]:
    whole = centred_floor(rng.uniform(*SIDE), rng.uniform(*SIDE))
    obstacles, rooms, doors = enclose(whole), [whole], list[Point]()
    undivided = []
    while rooms:
        room = rooms.pop()
        if (axis := _choose_axis(rng, room)) is None or not (parts := _split(rng, room, axis, doors)):
            undivided.append(room)
            continue
        wall, halves = parts
        obstacles += wall
        rooms += halves
    for room in undivided:
        obstacles += furnish(rng, room, doors, FURNITURE)
    return obstacles


def _choose_axis(rng: np.random.Generator, room: Rectangle) -> int | None:
    """Axis to cut a room across, the longer one more often; None if the room remains as it is."""
    sides = room.east - room.west, room.north - room.south
    can_split = [side > 2 * LEAST + THICKNESS for side in sides]
    if not any(can_split) or (max(sides) < LARGEST and rng.random() < KEPT):
        return None
    if all(can_split):
        return int(rng.random() * (sides[0] + sides[1]) > sides[0])
    return can_split.index(True)


def _split(
    rng: np.random.Generator, room: Rectangle, axis: int, doors: list[Point]
) -> tuple[list[Obstacle], list[Rectangle]] | None:
    """A wall across an axis, its door noted, and the rooms on its sides; None if every try ended in a door."""
    begin, end = room[1 - axis], room[3 - axis]
    for _ in range(_TRIES):
        low = rng.uniform(room[axis] + LEAST, room[axis + 2] - LEAST - THICKNESS)
        at = low + THICKNESS / 2
        if all(dist(_point(axis, at, side), door) > KEPT_FREE for door in doors for side in (begin, end)):
            break
    else:
        return None
    width = rng.uniform(*DOOR)
    first = rng.uniform(begin + JAMB, end - JAMB - width)
    doors.append(_point(axis, at, first + width / 2))
    wall = build_wall(1 - axis, at, (begin, end), [(first, first + width)])
    near, far = list(room), list(room)
    near[axis + 2], far[axis] = low, low + THICKNESS
    return wall, [Rectangle(*near), Rectangle(*far)]


def _point(axis: int, at: float, along: float) -> Point:
    return (at, along) if axis == 0 else (along, at)
