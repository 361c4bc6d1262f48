"""Cost of a reset into a new generated room: drawn, written into its slots, with free floor, start and goal."""

import time
from collections import defaultdict

import numpy as np

from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.rooms.changing_room import GENERATED
from tasks.rooms.reading import find_room

RESETS = 700
OBSTACLES = range(50, 71)  # of the rooms that the bar is for
BAR = 3.0  # ms, median


def changing_rooms() -> None:
    """Print the median CPU of a reset, ms, by generator and over rooms of some 60 obstacles, with its bar."""
    environment = NavigationEnv("nav_anywhere", config={"rooms": list(GENERATED)})
    environment.reset(seed=0)
    taken: dict[str, list[float]] = defaultdict(list)
    for _ in range(RESETS):
        begun = time.process_time()
        _, info = environment.reset()
        seconds = time.process_time() - begun
        taken[info["room"].partition(":")[0]].append(seconds)
        if len(find_room(info["room"]).obstacles) in OBSTACLES:
            taken["50 to 70 obstacles"].append(seconds)
    environment.close()
    for name, values in sorted(taken.items()):
        bar = f" (bar: at most {BAR:g})" if name.startswith("50") else ""
        print(f"{name:20} {1e3 * float(np.median(values)):5.2f} ms{bar}, {len(values)} of them")
