"""One seed, independent random streams by name."""

from typing import Literal, get_args

import numpy as np

Stream = Literal["start_goal", "exploration", "replay", "weights", "withdrawal", "smoothing"]


def stream(seed: int, name: Stream) -> np.random.Generator:
    """The generator of that name; streams of one seed are independent of each other."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(get_args(Stream).index(name),)))
