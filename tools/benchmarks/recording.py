"""Costs of recording: CPU a step and disk space."""

import tempfile
import time
from pathlib import Path

import gymnasium
import numpy as np

from asddpg.build import make_agent, make_environment, navigation_env, prepare_torch
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.loop import run_episode
from asddpg.recording.files.reading import open_recording
from asddpg.recording.recorder import Recorder, Selection, every_nth
from asddpg.runs import weights_file
from asddpg.runs.loading import open_trained
from asddpg.runs.provenance import recording_provenance, versions
from tasks.evaluation_pairs import stored_pairs
from tasks.room_geometry.held_out import Pair

TASK = "nav_complex"
PAIRS, ROUNDS = 20, 11
MAX_CPU = 120  # µs a step
MAX_EPISODE_KB, MAX_STEP_BYTES = 18, 450


@prepare_torch()
def recording() -> None:
    """Print CPU a step with a recorder beyond that without, and the size of recordings, each with its bar."""
    trained = open_trained(f"pretrained:{TASK}")
    environment = make_environment(trained.config.task, trained.config.reward)
    agent = make_agent(trained.config, environment)
    weights_file.load_into(trained.weights, agent.networks)
    driver = FixedDriver(agent.decide_greedily)
    pairs = stored_pairs(TASK, "test", trained.config.task.goal_radius)[:PAIRS]
    made_with = versions()
    provenance = recording_provenance(trained.config, made_with)
    with tempfile.TemporaryDirectory() as folder:
        recorder = Recorder(Path(folder), navigation_env(environment), provenance, Selection(every_nth(1)), print)
        costs: list[list[float]] = []
        for _ in range(1 + ROUNDS):  # the first one warms up
            episodes = [_cost(environment, driver, pair, recorder) for pair in pairs]
            costs.append([cost for cost, _ in episodes])
            steps = [count for _, count in episodes]
        sizes = [(open_recording(path).outcome()["steps"], path.stat().st_size) for path in Path(folder).iterdir()]
    cpu = np.median(costs[1:], axis=0).sum() / sum(steps) * 1e6
    counts, space = np.array(sizes, dtype=float).T
    per_step, per_episode = np.polyfit(counts, space, 1)
    share = np.max(space / (MAX_EPISODE_KB * 1000 + MAX_STEP_BYTES * counts))
    print(f"{cpu:.0f} µs of CPU a step (bar: at most {MAX_CPU}), in episodes of {np.mean(steps):.0f} steps on average")
    print(
        f"{per_episode / 1000:.1f} kB an episode and {per_step:.0f} bytes a step "
        f"(bars: {MAX_EPISODE_KB} kB, {MAX_STEP_BYTES} bytes; the largest file has {share:.2f} of its bar)"
    )


def _cost(environment: gymnasium.Env, driver: FixedDriver, pair: Pair, recorder: Recorder) -> tuple[float, int]:
    """CPU seconds that recording an episode took beyond driving it, and its steps."""
    without, _ = _drive(environment, driver, pair, ())
    with_recorder, steps = _drive(environment, driver, pair, (recorder,))
    return with_recorder - without, steps


def _drive(
    environment: gymnasium.Env, driver: FixedDriver, pair: Pair, observers: tuple[Recorder, ...]
) -> tuple[float, int]:
    """CPU seconds and steps."""
    begun = time.process_time()
    episode = run_episode(environment, driver, observers, options=pair.reset_options)
    return time.process_time() - begun, episode.steps
