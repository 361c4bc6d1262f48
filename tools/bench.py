"""Speed: `python -m tools.bench`, or some of its parts, such as `python -m tools.bench environment rooms`.

Ratios are taken within one process, its parts in turn, so that machine noise touches both alike.

`environment`: a step through Gymnasium, as gymnasium.make gives it, against the cheapest raw loop of the same physics
steps under the same commands, with rays once at the end. `vector`: steps of 16 and of 64 robots in two threads, against
two such loops.

`training`: steps a second of the whole loop, AsDDPG against Stable-Baselines3's DDPG on the same Gymnasium id, with the
same convolutions in front, the same widths and batch, one update a step, one torch thread each: as the library comes,
and with denormal numbers flushed to zero, which this project does and the library does not; last with one convolutional
front for actor and critic, which is not its default.

`samples`: samples learned a second (updates times batch) by Stable-Baselines3's DDPG with 16 robots of one vector
environment at batch 256.

`timestep`: cost and accuracy of physics steps of 1, 2, 5 and 10 ms. `laser`: cost of a scan of 40 and of 682 beams.
`rooms`: cost of a control step in each room. `reset`: cost of a new start and goal. `recording`: CPU a step and disk
space of episodes recorded for Foxglove. `rendering`: cost of a picture. `checkpoint`: CPU of writing a training state,
as a share of the CPU of the training.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from asddpg.build import make_agent, make_environment, prepare_torch
from asddpg.command_line import train_config
from asddpg.config import TrainConfig
from asddpg.episodes.loop import run_episode
from asddpg.errors import import_extra
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks.options import argument, some_of
from tools.benchmarks import checkpoints, environments, physics, recording, rendering


@prepare_torch()
def training(steps: int = 1500) -> None:
    """Print training steps a second, ours and Stable-Baselines3's, and the ratio."""
    # Stable-Baselines3's DDPG updates the policy at every step: to compare, so must ours, whatever the default.
    alike = ["task=nav_complex", "agent.learning_starts=100", "agent.policy_every=1"]
    config = train_config(alike)
    from tools.benchmarks import stable_baselines  # with the bench extra alone

    loops: dict[str, Callable[[int], None]] = {
        "AsDDPG": _ours(config),
        "DDPG": _ours(train_config([*alike, "agent=ddpg"])),
        "SB3 DDPG": stable_baselines.training_loop(config, share_convolutions=False, is_flushed=False),
        "SB3 DDPG, flushed": stable_baselines.training_loop(config, share_convolutions=False),
        "SB3 DDPG, flushed, one front": stable_baselines.training_loop(config, share_convolutions=True),
        "AsDDPG by default": _ours(train_config(alike[:-1])),
    }
    speeds: dict[str, list[float]] = {name: [] for name in loops}
    for loop in loops.values():
        loop(300)
    for _ in range(5):
        for name, loop in loops.items():
            begun = time.perf_counter()
            loop(steps // 5)
            speeds[name].append(steps // 5 / (time.perf_counter() - begun))
    widths = "x".join(str(width) for width in config.network.widths)
    print(f"batch {config.agent.batch_size}, layers {widths}, one thread")
    for name, values in speeds.items():
        print(f"{name:30} {np.median(values):6.1f} steps/s")
    for name in [name for name in loops if name.startswith("SB3")]:
        ratio = np.median(np.divide(speeds["AsDDPG"], speeds[name]))
        print(f"AsDDPG / {name}: {ratio:.2f} (bar: at least 1.2)")


@prepare_torch()
def samples(steps: int = 960, warm_up: int = 320) -> None:
    """Print the samples that Stable-Baselines3's DDPG learns a second with 16 robots."""
    from tools.benchmarks import stable_baselines  # with the bench extra alone

    config, batch, updates = train_config(["task=nav_complex"]), 256, 2
    loops: dict[str, Callable[[int], float]] = {
        "SB3 DDPG": stable_baselines.sample_loop(config, batch_size=batch, gradient_steps=updates),
    }
    learned = steps * updates * batch / stable_baselines.ROBOTS  # in a call
    for loop in loops.values():
        loop(warm_up)
    turns = [{name: learned / loop(steps) for name, loop in loops.items()} for _ in range(5)]
    print(f"{updates} updates of {batch} for the {stable_baselines.ROBOTS} steps of as many robots, one thread")
    for name in loops:
        print(f"{name:30} {np.median([turn[name] for turn in turns]):6.0f} samples/s")


def _ours(config: TrainConfig) -> Callable[[int], None]:
    env = make_environment(config.task, config.reward)
    agent = make_agent(config, env)
    env.reset(seed=0)

    def loop(steps: int) -> None:
        done = 0
        while done < steps:
            done += run_episode(env, agent, max_steps=steps - done).steps

    return loop


PARTS: dict[str, Callable[[], None]] = {
    "environment": environments.environment,
    "vector": environments.vector,
    "training": training,
    "samples": samples,
    "timestep": physics.timestep,
    "laser": physics.laser,
    "rooms": physics.rooms,
    "reset": physics.reset,
    "recording": recording.recording,
    "rendering": rendering.rendering,
    "checkpoint": checkpoints.checkpoint,
}


@dataclass(frozen=True)
class BenchArguments:
    """What is measured."""

    parts: list[str] = argument("Benchmarks to run; none runs all.", [], some_of(*PARTS))


def main(arguments: Sequence[str]) -> None:
    """Run some benchmarks, or all."""
    parts = parse_arguments(BenchArguments, arguments).parts or PARTS
    if {"training", "samples"} & set(parts):
        import_extra("stable_baselines3", "bench", "comparisons of training")
    for name in parts:
        print(f"== {name}")
        PARTS[name]()


if __name__ == "__main__":
    run(main, help_text(__doc__, BenchArguments))
