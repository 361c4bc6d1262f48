"""The state of a NumPy generator as plain values, streams that it spawns later included."""

from collections.abc import Mapping
from typing import Any

import numpy as np

RandomSource = int | np.random.Generator | np.random.RandomState | None


def generator_state(rng: np.random.Generator) -> dict[str, Any]:
    """Whole numbers, strings, dicts and lists; whole numbers of up to 128 bits."""
    seeds: Any = rng.bit_generator.seed_seq
    return {
        "stream": rng.bit_generator.state,
        "entropy": seeds.entropy,
        "spawn_key": list(seeds.spawn_key),
        "num_spawned": seeds.n_children_spawned,
    }


def restored_generator(state: Mapping[str, Any]) -> np.random.Generator:
    """The generator that generator_state() read."""
    seeds = np.random.SeedSequence(
        state["entropy"], spawn_key=tuple(state["spawn_key"]), n_children_spawned=state["num_spawned"]
    )
    rng = np.random.Generator(np.random.PCG64(seeds))
    rng.bit_generator.state = state["stream"]
    return rng


def make_generator(random: RandomSource) -> np.random.Generator:
    """A generator of a seed, of another generator (itself), or of a RandomState, as dm_control's tasks take one."""
    if isinstance(random, np.random.RandomState):
        random = random.randint(2**31)
    return np.random.default_rng(random)
