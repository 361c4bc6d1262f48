"""Starts and goals of a room's validation and test: its own, or drawn by a hash of the room."""

import hashlib

import numpy as np

from tasks.physics import FloatArray, Pose
from tasks.room_geometry.free_space import CELL
from tasks.room_geometry.held_out import Pair, SetName
from tasks.room_geometry.start_goal import HELD_OUT_MARGIN
from tasks.rooms.room import Room
from tasks.rooms.room_rule import RoomRule

SIZES: dict[SetName, int] = {"validation": 50, "test": 200}
MOST_HELD_OUT = 0.25  # of the floor: training keeps off the surroundings of the goals


def draw_sets(room: Room, rule: RoomRule) -> dict[SetName, tuple[Pair, ...]]:
    """The pairs of both sets, their shortest paths not yet known (inf): the same in every process.

    A goal of one set keeps HELD_OUT_MARGIN from those of the other, and a small room has fewer pairs.
    """
    if room.pairs:
        own = tuple(Pair(start, goal, np.inf) for start, goal in room.pairs)
        return {"validation": own, "test": own}
    rng = np.random.default_rng(int(room_digest(room), 16))
    held_out_area = sum(SIZES.values()) * np.pi * HELD_OUT_MARGIN**2
    share = min(1.0, MOST_HELD_OUT * len(rule.places) * CELL**2 / held_out_area)
    sets: dict[SetName, tuple[Pair, ...]] = {}
    others = np.zeros((0, 2))
    for name, size in SIZES.items():
        sets[name] = tuple(_draw(rule, rng, others) for _ in range(max(1, round(size * share))))
        others = np.array([pair.goal for pair in sets[name]])
    return sets


def _draw(rule: RoomRule, rng: np.random.Generator, held_out: FloatArray) -> Pair:
    start, (x, y) = rule.draw(rng, held_out)
    # Millimetres, and thousandths of a radian, are enough to write down.
    return Pair(Pose(*(round(value, 3) for value in start)), (round(x, 3), round(y, 3)), np.inf)


def room_digest(room: Room) -> str:
    """SHA-256 of a room's obstacles and pairs, 16 hex digits."""
    return hashlib.sha256(repr((room.obstacles, room.pairs)).encode()).hexdigest()[:16]
