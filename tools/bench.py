"""Speed: `python -m tools.bench`, or some of its parts, such as `python -m tools.bench environment rooms`.

Ratios are taken within one process, its parts in turn, so that machine noise touches both alike.

`environment`: a step through Gymnasium, as gymnasium.make gives it, against the cheapest raw loop of the same physics
steps under the same commands, with rays once at the end. `vector`: steps of 16 and of 64 robots in two threads, against
two such loops.

`training`: where the time of a training step goes. `one_robot`: steps a second of the whole loop with one robot, AsDDPG
against Stable-Baselines3's DDPG on the same Gymnasium id, with the same convolutions in front, the same widths, an
update of 32 a step, one torch thread each; denormal numbers flushed to zero, which this project does and the library
does not; also as the library comes, and with one convolutional front for actor and critic, which is not its default.
`samples`: samples learned a second with 16 robots and two updates of 256 for their 16 steps, ours and the library's.

`timestep`: cost and accuracy of physics steps of 1, 2, 5 and 10 ms. `laser`: cost of a scan of 40 and of 682 beams.
`rooms`: cost of a control step in each room. `reset`: cost of a new start and goal, `changing_rooms`: of a
new room with them. `recording`: CPU a step and disk
space of episodes recorded for Foxglove. `rendering`: cost of a picture. `checkpoint`: CPU of writing a training state,
as a share of the CPU of the training. `planning`: a decision of DWA, a global plan and an update of AMCL in the office.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from asddpg.errors import import_extra
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks.options import argument, some_of
from tools.benchmarks import (
    changing_rooms,
    checkpoints,
    environments,
    physics,
    planning,
    recording,
    rendering,
    training,
)

PARTS: dict[str, Callable[[], None]] = {
    "environment": environments.environment,
    "vector": environments.vector,
    "training": training.training,
    "one_robot": training.one_robot,
    "samples": training.samples,
    "timestep": physics.timestep,
    "laser": physics.laser,
    "rooms": physics.rooms,
    "reset": physics.reset,
    "changing_rooms": changing_rooms.changing_rooms,
    "recording": recording.recording,
    "rendering": rendering.rendering,
    "checkpoint": checkpoints.checkpoint,
    "planning": planning.planning,
}


@dataclass(frozen=True)
class BenchArguments:
    """What is measured."""

    parts: list[str] = argument("Benchmarks to run; none runs all.", [], some_of(*PARTS))


def main(arguments: Sequence[str]) -> None:
    """Run some benchmarks, or all."""
    parts = parse_arguments(BenchArguments, arguments).parts or PARTS
    if {"one_robot", "samples"} & set(parts):
        import_extra("stable_baselines3", "bench", "comparisons of training")
    for name in parts:
        print(f"== {name}")
        PARTS[name]()


if __name__ == "__main__":
    run(main, help_text(__doc__, BenchArguments))
