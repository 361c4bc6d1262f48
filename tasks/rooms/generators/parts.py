"""What rooms are made of: walls with openings, things at any yaw, furniture."""

from collections.abc import Iterable, Sequence
from itertools import chain
from math import cos, dist, hypot, sin
from typing import NamedTuple

import numpy as np

from tasks.rooms.room import Obstacle, Point, Quaternion, box

THICKNESS = 0.1  # m, of walls
KEPT_FREE = 0.9  # m around the middle of a door, where neither furniture nor the end of a wall stands
_TRIES = 4  # at a place for a piece of furniture

Span = tuple[float, float]


class Rectangle(NamedTuple):
    """A part of the floor: the coordinates of its sides, metres."""

    west: float
    south: float
    east: float
    north: float


def turn(yaw: float) -> Quaternion:
    """A turn about the vertical, rad."""
    return cos(yaw / 2), 0.0, 0.0, sin(yaw / 2)


def build_wall(axis: int, at: float, span: Span, openings: Iterable[Span] = ()) -> list[Obstacle]:
    """A straight wall, in pieces where it has openings.

    Args:
        axis: that it runs along, 0 for x and 1 for y.
        at: its middle on the other axis, metres.
        span: where it begins and ends, metres.
        openings: where each begins and ends, metres, in order and apart.
    """
    ends = [span[0], *chain.from_iterable(openings), span[1]]
    pieces = []
    for begin, end in zip(ends[::2], ends[1::2], strict=True):
        middle, half = (begin + end) / 2, (end - begin) / 2
        place = (middle, at, half, THICKNESS / 2) if axis == 0 else (at, middle, THICKNESS / 2, half)
        pieces.append(box(*place, name="wall"))
    return pieces


def enclose(floor: Rectangle) -> list[Obstacle]:
    """Four walls around a floor, which it touches."""
    half = THICKNESS / 2
    along_x, along_y = (floor.west - THICKNESS, floor.east + THICKNESS), (floor.south, floor.north)
    return [
        *build_wall(0, floor.south - half, along_x),
        *build_wall(0, floor.north + half, along_x),
        *build_wall(1, floor.west - half, along_y),
        *build_wall(1, floor.east + half, along_y),
    ]


def centred_floor(width: float, depth: float) -> Rectangle:
    """A floor around the origin; metres along x and along y."""
    return Rectangle(-width / 2, -depth / 2, width / 2, depth / 2)


def furnish(rng: np.random.Generator, floor: Rectangle, doors: Sequence[Point], most: int) -> list[Obstacle]:
    """Up to `most` boxes, each along a wall of a floor, away from the middles of its doors."""
    pieces = []
    for _ in range(int(rng.integers(most + 1))):
        half_x, half_y = rng.uniform(0.15, 0.6), rng.uniform(0.15, 0.4)
        for _ in range(_TRIES):
            x, y = draw_place(rng, floor, half_x, half_y)
            side = int(rng.integers(4))
            x = (floor.west + half_x, x, floor.east - half_x, x)[side]
            y = (y, floor.south + half_y, y, floor.north - half_y)[side]
            if all(dist((x, y), door) > hypot(half_x, half_y) + KEPT_FREE for door in doors):
                pieces.append(box(x, y, half_x, half_y))
                break
    return pieces


def draw_place(rng: np.random.Generator, floor: Rectangle, half_x: float, half_y: float) -> Point:
    """A place for the middle of a thing of these half sides on a floor, metres."""
    return (
        rng.uniform(floor.west + half_x, floor.east - half_x),
        rng.uniform(floor.south + half_y, floor.north - half_y),
    )
