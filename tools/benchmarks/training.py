"""Speed of training: where the time of a step goes, and what Stable-Baselines3 needs for the same."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from asddpg.build import count_driving_threads, make_agent, make_robots, prepare_torch
from asddpg.command_line import train_config
from asddpg.config import TrainConfig
from asddpg.episodes.training_episodes import TrainingEpisodes

TASK = "task=nav_complex"
EARLY = "agent.learning_starts=300"
# An update of 32 after each step, as Algorithm 1 and Stable-Baselines3's DDPG do, whose policy learns in every one.
ONE_ROBOT = ["robots=1", "agent.batch_size=32", "agent.samples_per_step=32", "agent.policy_every=1"]
ROUNDS, TURN = 5, 320  # turns of each loop, and training steps in one
BAR_ONE_ROBOT, BAR_SAMPLES = 1.3, 2.0


@prepare_torch()
def training() -> None:
    """Print where the time of a training step goes, by default and with one robot."""
    for title, options in (("by default", []), ("one robot, an update of 32 a step", ONE_ROBOT[:-1])):
        config = train_config([TASK, EARLY, *options])
        episodes = _make_episodes(config)
        _drive(episodes, 600)
        print(f"-- {title}: {config.robots} robots, batch {config.agent.batch_size}")
        _print_shares(episodes, steps=4800 if config.robots > 1 else 1200)


@prepare_torch()
def one_robot() -> None:
    """Print training steps a second with one robot, ours and those of Stable-Baselines3's DDPG, and the ratio."""
    from tools.benchmarks import stable_baselines  # with the bench extra alone

    config = train_config([TASK, EARLY, *ONE_ROBOT])
    loops: dict[str, Callable[[int], None]] = {
        "AsDDPG": _loop(config),
        "DDPG": _loop(train_config([TASK, EARLY, *ONE_ROBOT, "agent=ddpg"])),
        "SB3 DDPG": stable_baselines.training_loop(config, share_convolutions=False, is_flushed=False),
        "SB3 DDPG, flushed": stable_baselines.training_loop(config, share_convolutions=False),
        "SB3 DDPG, flushed, one front": stable_baselines.training_loop(config, share_convolutions=True),
        "AsDDPG, the policy's updates by default": _loop(train_config([TASK, EARLY, *ONE_ROBOT[:-1]])),
    }
    _print_ratios(_in_turn(loops, warm_up=600), 1, "steps/s", BAR_ONE_ROBOT)


@prepare_torch()
def samples() -> None:
    """Print the samples learned a second with many robots, ours and Stable-Baselines3's, and the ratio."""
    from tools.benchmarks import stable_baselines  # with the bench extra alone

    alike = ["agent.samples_per_step=32", "agent.policy_every=1"]
    config = train_config([TASK, EARLY, *alike])
    sb3 = stable_baselines.sample_loop(config, config.agent.batch_size, gradient_steps=2)
    loops: dict[str, Callable[[int], Any]] = {
        "DDPG": _loop(train_config([TASK, EARLY, *alike, "agent=ddpg"])),
        "AsDDPG": _loop(config),
        "AsDDPG, the policy's updates by default": _loop(train_config([TASK, EARLY, *alike[:1]])),
        "SB3 DDPG, flushed": sb3,
    }
    _print_ratios(_in_turn(loops, warm_up=640), config.agent.samples_per_step, "samples/s", BAR_SAMPLES)


def _in_turn(loops: Mapping[str, Callable[[int], Any]], warm_up: int) -> dict[str, list[float]]:
    """Steps a second of each loop in each turn."""
    for loop in loops.values():
        loop(warm_up)
    speeds: dict[str, list[float]] = {name: [] for name in loops}
    for _ in range(ROUNDS):
        for name, loop in loops.items():
            begun = time.perf_counter()
            loop(TURN)
            speeds[name].append(TURN / (time.perf_counter() - begun))
    return speeds


def _print_ratios(speeds: Mapping[str, list[float]], scale: int, unit: str, bar: float) -> None:
    """Print the medians, times `scale`, and what ours are of Stable-Baselines3's with denormal numbers flushed."""
    for name, values in speeds.items():
        print(f"{name:40} {scale * np.median(values):7.1f} {unit}")
    for name, values in speeds.items():
        if not name.startswith("SB3"):
            ratio = np.median(np.divide(values, speeds["SB3 DDPG, flushed"]))
            print(f"{name} / SB3 DDPG, flushed: {ratio:.2f} (bar: at least {bar})")


def _make_episodes(config: TrainConfig) -> TrainingEpisodes:
    robots = make_robots(config.task, config.reward, config.robots, count_driving_threads())
    return TrainingEpisodes(robots, make_agent(config, robots.envs[0]), config.seed)


def _loop(config: TrainConfig) -> Callable[[int], None]:
    episodes = _make_episodes(config)
    return lambda steps: _drive(episodes, steps)


def _drive(episodes: TrainingEpisodes, steps: int) -> None:
    end = episodes.step + steps
    while episodes.step < end:
        episodes.drive_step(total_steps=10**9)


# Where time goes -----------------------------------------------------------------------------------------------------

# Methods of agent and environment by what they are for.
PARTS = {
    "decide": "decisions",
    "begin_step": "simulation: begun",
    "finish_step": "simulation: waited for, and read",
    "reset": "simulation: new episodes",
    "learn": "update",
    "store": "replay buffer",
}


@dataclass
class _Timed:
    """An object whose methods' wall-clock seconds are added up by name."""

    inner: Any
    seconds: dict[str, float] = field(default_factory=dict)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self.inner, name)
        if name not in PARTS:
            return found

        def call(*arguments: Any, **options: Any) -> Any:
            begun = time.perf_counter()
            try:
                return found(*arguments, **options)
            finally:
                self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begun

        return call


def _print_shares(episodes: TrainingEpisodes, steps: int) -> None:
    agent, robots = _Timed(episodes._agent), _Timed(episodes._environment)
    episodes._agent, episodes._environment = agent, robots
    wall, process, thread = time.perf_counter(), time.process_time(), time.thread_time()
    _drive(episodes, steps)
    wall, process, thread = (
        now - then for now, then in zip((time.perf_counter(), time.process_time(), time.thread_time()),
                                        (wall, process, thread), strict=True)
    )  # fmt: skip
    seconds = agent.seconds | robots.seconds
    for name, title in PARTS.items():
        part = seconds.get(name, 0.0)
        print(f"{title:34} {part / steps * 1e6:8.0f} µs a step {part / wall:6.1%}")
    rest = wall - sum(seconds.values())
    print(f"{'counting, checks':34} {rest / steps * 1e6:8.0f} µs a step {rest / wall:6.1%}")
    print(f"{'all, by the clock':34} {wall / steps * 1e6:8.0f} µs a step = {steps / wall:.0f} steps/s")
    print(f"processor time {process / steps * 1e6:.0f} µs a step, {process / wall:.2f} cores at work,")
    print(f"of it {(process - thread) / process:.0%} in threads beside the main one: simulation and policy")
