"""A corridor with rooms on both sides behind doors, and corridors that branch off."""

import numpy as np

from tasks.rooms.generators.connected import draw_connected
from tasks.rooms.generators.parts import THICKNESS, Rectangle, Span, build_wall, enclose, furnish
from tasks.rooms.room import Obstacle, Room

LENGTH = (8.0, 15.0)  # m, of the corridor
WIDTH = (1.2, 2.4)  # m, of corridors between their walls
DOOR = 0.9  # m wide
DEPTH = (2.5, 4.5)  # m, of the rooms on a side
ROOM = (2.4, 4.5)  # m, width of a room
BRANCH = 0.25  # chance of a corridor in the place of a room, beside a room
JAMB = 0.15  # m from a door to the next wall, at least
FURNITURE = 3  # pieces in a room, at most


def draw_corridors(rng: np.random.Generator) -> Room:
    """Draw a corridor along x whose rooms have a door of 0.9 m each, and corridors without a door that branch off."""
    return draw_connected(_sketch, rng)


def _sketch(rng: np.random.Generator) -> list[Obstacle]:
    length, half = rng.uniform(*LENGTH) / 2, rng.uniform(*WIDTH) / 2
    north, south = half + THICKNESS + rng.uniform(*DEPTH), -half - THICKNESS - rng.uniform(*DEPTH)
    upper = _draw_side(rng, half, Rectangle(-length, half + THICKNESS, length, north))
    lower = _draw_side(rng, -half, Rectangle(-length, south, length, -half - THICKNESS))
    return [*enclose(Rectangle(-length, south, length, north)), *upper, *lower]


def _draw_side(rng: np.random.Generator, face: float, floor: Rectangle) -> list[Obstacle]:
    """The rooms on one side, and their wall towards the corridor, whose face lies at y = face."""
    at = face + (THICKNESS if face > 0 else -THICKNESS) / 2
    obstacles, openings, west, is_branch = list[Obstacle](), list[Span](), floor.west, False
    while west < floor.east:
        is_branch = not is_branch and rng.random() < BRANCH
        east = west + rng.uniform(*(WIDTH if is_branch else ROOM))
        if floor.east - east < THICKNESS + ROOM[0]:
            is_branch, east = False, floor.east
        room = Rectangle(west, floor.south, east, floor.north)
        if is_branch:
            openings.append((west, east))
        else:
            openings.append(door := _draw_door(rng, room))
            obstacles += furnish(rng, room, [((door[0] + door[1]) / 2, at)], FURNITURE)
        if east < floor.east:
            obstacles += build_wall(1, east + THICKNESS / 2, (floor.south, floor.north))
        west = east + THICKNESS
    return [*obstacles, *build_wall(0, at, (floor.west - THICKNESS, floor.east + THICKNESS), openings)]


def _draw_door(rng: np.random.Generator, room: Rectangle) -> Span:
    west = rng.uniform(room.west + JAMB, room.east - JAMB - DOOR)
    return west, west + DOOR
