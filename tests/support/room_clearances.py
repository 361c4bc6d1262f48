"""Distances in a room that was compiled."""

import numpy.typing as npt

from tasks.physics import FloatArray
from tasks.room_geometry.obstacles import Obstacles
from tasks.rooms.room import Room
from tasks.rooms.scene import compile_room


def room_clearances(room: Room, points: npt.ArrayLike) -> FloatArray:
    """Distances from points, (n, 2), to the nearest obstacle of the compiled room, 0 inside one; metres."""
    return Obstacles.from_model(compile_room(room)).clearance(points)
