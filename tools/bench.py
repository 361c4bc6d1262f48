"""Speed: `python -m tools.bench`, or some of its parts, such as `python -m tools.bench environment rooms`.

Ratios are taken within one process, its parts in turn, so that machine noise touches both alike.

`environment`: a step through Gymnasium, as gymnasium.make gives it, against the cheapest raw loop of the same physics
steps under the same commands, with rays once at the end. `vector`: steps of 16 and of 64 robots in two threads, against
two such loops.

`training`: steps a second of the whole loop, AsDDPG against Stable-Baselines3's DDPG on the same Gymnasium id, with the
same convolutions in front, the same widths and batch, one update a step, one torch thread each: as the library comes,
and with denormal numbers flushed to zero, which this project does and the library does not; last with one convolutional
front for actor and critic, which is not its default.

`timestep`: cost and accuracy of physics steps of 1, 2, 5 and 10 ms. `laser`: cost of a scan of 40 and of 682 beams.
`rooms`: cost of a control step in each room. `reset`: cost of a new start and goal. `recording`: CPU a step and disk
space of episodes recorded for Foxglove. `rendering`: cost of a picture. `checkpoint`: CPU of writing a training state,
as a share of the CPU of the training.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import gymnasium
import numpy as np
import torch

from asddpg.algorithm.networks import Features
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
    loops: dict[str, Callable[[int], None]] = {
        "AsDDPG": _ours(config),
        "DDPG": _ours(train_config([*alike, "agent=ddpg"])),
        "SB3 DDPG": _stable_baselines(config, share_convolutions=False, is_flushed=False),
        "SB3 DDPG, flushed": _stable_baselines(config, share_convolutions=False),
        "SB3 DDPG, flushed, one front": _stable_baselines(config, share_convolutions=True),
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


def _ours(config: TrainConfig) -> Callable[[int], None]:
    env = make_environment(config.task, config.reward)
    agent = make_agent(config, env)
    env.reset(seed=0)

    def loop(steps: int) -> None:
        done = 0
        while done < steps:
            done += run_episode(env, agent, max_steps=steps - done).steps

    return loop


def _stable_baselines(config: TrainConfig, share_convolutions: bool, is_flushed: bool = True) -> Callable[[int], None]:
    from stable_baselines3 import DDPG
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

    env = make_environment(config.task, config.reward)
    scan_shape = env.get_wrapper_attr("scan_shape")

    class Extractor(BaseFeaturesExtractor):  # type: ignore[misc,unused-ignore]  # without the bench extra
        def __init__(self, space: gymnasium.spaces.Box) -> None:
            super().__init__(space, 1)
            self.features = Features(space.shape[0], scan_shape)
            self._features_dim = self.features.size

        def forward(self, observation: torch.Tensor) -> torch.Tensor:
            found: torch.Tensor = self.features(observation)
            return found

    model = DDPG(
        "MlpPolicy",
        env,
        batch_size=config.agent.batch_size,
        learning_starts=100,
        train_freq=1,
        gradient_steps=1,
        buffer_size=config.agent.buffer_size,
        device="cpu",
        policy_kwargs={
            "net_arch": list(config.network.widths),
            "features_extractor_class": Extractor,
            "share_features_extractor": share_convolutions,
        },
    )

    def loop(steps: int) -> None:
        torch.set_flush_denormal(is_flushed)  # the library leaves the processor with denormal numbers
        model.learn(steps, reset_num_timesteps=False)
        torch.set_flush_denormal(True)

    return loop


PARTS: dict[str, Callable[[], None]] = {
    "environment": environments.environment,
    "vector": environments.vector,
    "training": training,
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
    if "training" in parts:
        import_extra("stable_baselines3", "bench", "comparisons of training")
    for name in parts:
        print(f"== {name}")
        PARTS[name]()


if __name__ == "__main__":
    run(main, help_text(__doc__, BenchArguments))
