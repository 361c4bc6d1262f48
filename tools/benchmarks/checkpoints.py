"""What checkpoints cost: CPU of writing one, as a share of the CPU of the training steps between two."""

import shutil
import tempfile
import time
from pathlib import Path

import numpy as np

from asddpg.algorithm.agent import AsDDPG
from asddpg.algorithm.replay import Transitions
from asddpg.build import make_agent, make_robots, prepare_torch
from asddpg.command_line import train_config
from asddpg.episodes.training_episodes import TrainingEpisodes
from asddpg.observers.step_log import COLUMNS
from asddpg.runs.rewind import log_lengths
from asddpg.runs.run_folder import RunFolder
from asddpg.runs.training_states import TrainingStates
from tasks.constants import NUM_BEAMS, NUM_SCANS

ROUNDS, STEPS = 5, 400


@prepare_torch()
def checkpoint() -> None:
    """Print the share, with a full replay buffer and logs as long as it, and the disk space."""
    config = train_config(["task=nav_complex"])
    robots = make_robots(config.task, config.reward, config.robots)
    agent = make_agent(config, robots.envs[0])
    episodes = TrainingEpisodes(robots, agent, config.seed)
    _fill(agent, config.agent.buffer_size)
    steps, writes, walls = [], [], []
    with tempfile.TemporaryDirectory() as path:
        folder = RunFolder(Path(path))
        states = TrainingStates(folder.training_states)
        np.zeros((config.agent.buffer_size, len(COLUMNS)), np.float32).tofile(folder.step_rows)
        _drive(episodes, STEPS)  # to warm up
        for round_ in range(ROUNDS):
            steps.append(_drive(episodes, STEPS))
            begun, wall = time.process_time(), time.perf_counter()
            states.write(round_, {"episodes": episodes.state(), "files": log_lengths(folder.path)})
            writes.append(time.process_time() - begun)
            walls.append(time.perf_counter() - wall)
        size = sum(file.stat().st_size for file in states.paths()[-1].iterdir())
        free = shutil.disk_usage(path).free
    every = config.checkpoint_every
    share, shares = np.median(writes) / (np.median(steps) * every), np.divide(writes, steps) / every
    print(f"{config.agent.buffer_size} transitions: {size / 1e6:.0f} MB, of {free / 1e9:.0f} GB free; two are kept")
    print(f"{np.median(writes) * 1e3:.0f} ms of CPU, {np.median(walls) * 1e3:.0f} ms on the clock a checkpoint")
    print(f"{np.median(steps) * 1e3:.2f} ms of CPU a training step, {every} steps between two")
    print(f"share {share:.2%} (bar: at most 2 %; rounds {min(shares):.2%} to {max(shares):.2%})")


def _fill(agent: AsDDPG, count: int) -> None:
    """Give the agent a full replay buffer, of numbers like those of scans."""
    rng, robots, zeros = np.random.default_rng(0), np.arange(agent.robots), np.zeros(agent.robots)
    actions = np.zeros((agent.robots, 2), np.float32)
    for _ in range(count // agent.robots):
        scans = np.tile(rng.uniform(-0.5, 0.5, (agent.robots, NUM_BEAMS)), NUM_SCANS)
        observations = np.column_stack((scans, rng.uniform(-1, 1, (agent.robots, 4)))).astype(np.float32)
        numbers = agent.replay.observe(observations, robots)
        agent.replay.add(Transitions(numbers, actions, zeros, zeros, zeros, zeros, numbers, actions))


def _drive(episodes: TrainingEpisodes, steps: int) -> float:
    """CPU seconds a training step."""
    begun, end = time.process_time(), episodes.step + steps
    while episodes.step < end:
        episodes.drive_step(total_steps=10**9)
    return (time.process_time() - begun) / steps
