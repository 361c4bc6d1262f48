"""The generators by their names, and the rooms by their numbers."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from tasks.errors import TaskError
from tasks.rooms.generators.bare_floor import draw_bare
from tasks.rooms.generators.clutter import draw_clutter
from tasks.rooms.generators.corridors import draw_corridors
from tasks.rooms.generators.cylinders import draw_cylinders
from tasks.rooms.generators.legs import draw_legs
from tasks.rooms.generators.maze import draw_maze
from tasks.rooms.generators.open_floor import draw_open
from tasks.rooms.generators.rooms import draw_rooms
from tasks.rooms.room import Room

GENERATORS: Mapping[str, Callable[[np.random.Generator], Room]] = MappingProxyType(
    {
        "cylinders": draw_cylinders,
        "clutter": draw_clutter,
        "legs": draw_legs,
        "corridors": draw_corridors,
        "maze": draw_maze,
        "rooms": draw_rooms,
        "open": draw_open,
        "bare": draw_bare,
    }
)


def generated_room(name: str, number: int) -> Room:
    """The room of a generator that has a number; it follows from the two alone, to the last bit.

    Args:
        name: of the generator, a key of GENERATORS.
        number: of the room, 0 or more; rooms of different numbers are independent.

    Raises:
        TaskError: there is no such generator, or the number is negative.
    """
    if name not in GENERATORS:
        raise TaskError(f"no generator of rooms is called {name!r}; there are {', '.join(GENERATORS)}")
    if number < 0:
        raise TaskError(f"the number of a room must be 0 or more, not {number}")
    # By the letters of the name: the order of the generators and those that come later change no room.
    seeds = np.random.SeedSequence(number, spawn_key=tuple(name.encode()))
    return GENERATORS[name](np.random.Generator(np.random.PCG64(seeds)))
