"""Starts and goals of a room's validation and test: its own, or drawn by a hash of the room."""

import hashlib

import numpy as np

from tasks.physics import Pose
from tasks.room_geometry.held_out import Pair, SetName
from tasks.room_geometry.start_goal import PairRule
from tasks.rooms.room import Room

SIZES: dict[SetName, int] = {"validation": 50, "test": 200}


def draw_sets(room: Room, rule: PairRule) -> dict[SetName, tuple[Pair, ...]]:
    """The pairs of both sets, their shortest paths not yet known (inf): the same in every process."""
    if room.pairs:
        own = tuple(Pair(start, goal, np.inf) for start, goal in room.pairs)
        return {"validation": own, "test": own}
    rng = np.random.default_rng(int(room_digest(room), 16))
    return {name: tuple(_draw(rule, rng) for _ in range(size)) for name, size in SIZES.items()}


def _draw(rule: PairRule, rng: np.random.Generator) -> Pair:
    start, (x, y) = rule.draw(rng, np.zeros((0, 2)))
    # Millimetres, and thousandths of a radian, are enough to write down.
    return Pair(Pose(*(round(value, 3) for value in start)), (round(x, 3), round(y, 3)), np.inf)


def room_digest(room: Room) -> str:
    """SHA-256 of a room's obstacles and pairs, 16 hex digits."""
    return hashlib.sha256(repr((room.obstacles, room.pairs)).encode()).hexdigest()[:16]
