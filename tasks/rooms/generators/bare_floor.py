"""A floor with nothing in sight."""

import numpy as np

from tasks.rooms.generators.open_floor import draw_pair
from tasks.rooms.room import Room

GOAL = (1.5, 8.0)  # m, from its start


def draw_bare(rng: np.random.Generator) -> Room:
    """Draw a start at the origin, any heading, and a goal 1.5 to 8 m away; the laser sees nothing on the way."""
    return Room((), pairs=(draw_pair(rng, GOAL),))
