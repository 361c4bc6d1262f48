"""What recording costs: CPU a step and room on the disk."""

import dataclasses
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import gymnasium
import numpy as np

from asddpg.build import make_agent, make_environment, prepare_torch, watched
from asddpg.drivers import FixedDriver, with_switch
from asddpg.loop import run_episode
from asddpg.recording.reading import open_recording
from asddpg.recording.recorder import Recorder, Selection, each
from asddpg.run_folder import config_text
from asddpg.train import provenance_of, versions
from asddpg.trained import open_trained
from tasks.fresh_pairs import stored_pairs
from tasks.held_out import Pair

TASK = "nav_complex"
PAIRS, ROUNDS = 20, 9


def recording() -> None:
    """Print CPU a step with a recorder beyond that without, and how large recordings are."""
    prepare_torch()
    trained = open_trained(f"pretrained:{TASK}")
    environment = make_environment(trained.config.task, trained.config.reward)
    agent = make_agent(trained.config, environment)
    trained.load_into(agent)
    driver = with_switch(agent)
    pairs = stored_pairs(TASK, "test", trained.config.task.goal_radius)[:PAIRS]
    made_with = versions()
    settings = config_text(dataclasses.asdict(trained.config), made_with)
    provenance = provenance_of(trained.config, settings, made_with)
    with tempfile.TemporaryDirectory() as folder:
        recorder = Recorder(Path(folder), watched(environment), provenance, Selection(each(1), keep=PAIRS), print)
        _drive(environment, driver, pairs, (recorder,))  # once to warm up
        costs = []
        for _ in range(ROUNDS):
            without, steps = _drive(environment, driver, pairs, ())
            with_recorder, _ = _drive(environment, driver, pairs, (recorder,))
            costs.append((with_recorder - without) / steps)
        sizes = [(open_recording(path).outcome()["steps"], path.stat().st_size) for path in Path(folder).iterdir()]
    print(f"{np.median(costs) * 1e6:.0f} us of CPU a step (bar: under 80; rounds {_span(costs)}), files and all")
    counts, room = np.array(sizes, dtype=float).T
    per_step, per_episode = np.polyfit(counts, room, 1)
    print(f"{per_episode / 1000:.1f} kB an episode and {per_step:.0f} bytes a step (bar: under 15 kB and 450 bytes)")
    print(
        f"{np.mean(room) / 1000:.1f} kB an episode of {np.mean(counts):.0f} steps on average; at the bar "
        f"{(15_000 + 450 * np.mean(counts)) / 1000:.1f} kB"
    )


def _span(costs: list[float]) -> str:
    return f"{min(costs) * 1e6:.0f} to {max(costs) * 1e6:.0f}"


def _drive(
    environment: gymnasium.Env, driver: FixedDriver, pairs: Sequence[Pair], observers: tuple[Recorder, ...]
) -> tuple[float, int]:
    """CPU seconds and steps of an episode for each pair."""
    begun = time.process_time()
    steps = sum(
        run_episode(environment, driver, observers, options={"start": pair.start, "goal": pair.goal}).steps
        for pair in pairs
    )
    return time.process_time() - begun, steps
