"""One training of a peer until its actor is good: its clocks, its file, the table of several."""

import json
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from asddpg.config import TrainConfig
from asddpg.errors import UserError
from asddpg.messages import print_line
from asddpg.runs.run_folder import write_json
from asddpg.training import make_validation_robots, validate
from tools.benchmarks.peer_settings import SETTINGS
from tools.experiments.tables import markdown

COLUMNS = (
    "task",
    "algorithm",
    "setting",
    "seed",
    "minutes of training",
    "with evaluations",
    "steps",
    "updates",
    "steps/s",
)
Float32Array = npt.NDArray[np.float32]
Rates = Callable[[], tuple[float, float]]  # success and collisions of the actor alone


@dataclass(frozen=True)
class Evaluation:
    """The actor alone on the validation pairs."""

    training_seconds: float
    wall_seconds: float  # with the evaluations
    steps: int  # of all robots
    success_rate: float
    collision_rate: float


@dataclass
class PeerRun:
    """A run, as its file holds it.

    Attributes:
        environment: digest of task, reward and number of validation pairs.
        target: the success rate that ends it.
        limit_minutes: of training, evaluations not counted, that end it too.
        updates: gradient steps made.
    """

    task: str
    algorithm: str
    setting: str
    seed: int
    environment: str
    target: float
    limit_minutes: float
    updates: int = 0
    evaluations: list[Evaluation] = field(default_factory=list)

    @property
    def title(self) -> str:
        """Its name, and that of its file."""
        return f"{self.task}_{self.algorithm}_{self.setting}_seed{self.seed}"

    @property
    def is_reached(self) -> bool:
        """Whether the last evaluation reached the target."""
        return bool(self.evaluations) and self.evaluations[-1].success_rate >= self.target

    @property
    def best(self) -> float:
        """The largest success rate of its evaluations."""
        return max(each.success_rate for each in self.evaluations)

    @property
    def minutes(self) -> float:
        """Of training, up to the last evaluation."""
        return self.evaluations[-1].training_seconds / 60.0

    def write(self, path: Path) -> None:
        """Write its file: the fields, and the setting's options in words."""
        write_json(path, asdict(self) | {"options": SETTINGS[self.setting]._asdict()})

    @classmethod
    def read(cls, path: Path) -> "PeerRun":
        """Read a file; UserError where it is damaged."""
        try:
            content = json.loads(path.read_bytes())
            del content["options"]
            return cls(**content | {"evaluations": [Evaluation(**each) for each in content["evaluations"]]})
        except (ValueError, KeyError, TypeError) as error:
            raise UserError(f"{path} is not a whole run of tools.benchmarks.compare_peers: {error}") from error


def train(peer: PeerRun, model: Any, rate: Rates, every: int) -> None:
    """Train until the actor reaches the target or the limit is up, with an evaluation every so many steps.

    Args:
        peer: the run; its figures are filled in.
        model: of Stable-Baselines3.
        rate: drives the evaluation.
        every: steps of all robots.
    """
    limit, trained, begun = peer.limit_minutes * 60.0, 0.0, time.perf_counter()
    while trained < limit and not peer.is_reached:
        since, left = time.perf_counter(), limit - trained
        until = since + left
        model.learn(every, lambda *_, until=until: time.perf_counter() < until, reset_num_timesteps=False)
        trained += time.perf_counter() - since
        peer.updates = model._n_updates
        success, collisions = rate()
        found = Evaluation(trained, time.perf_counter() - begun, model.num_timesteps, success, collisions)
        peer.evaluations.append(found)
        print_line(
            f"{peer.title}: {trained:.0f} s of training, {found.wall_seconds:.0f} s in all, {found.steps} steps, "
            f"success {success:.2f}, collisions {collisions:.2f}"
        )


def rates_of(predict: Callable[[Float32Array], Float32Array], config: TrainConfig) -> Rates:
    """The rates of a driver on the stored validation pairs, as a training of ours takes them.

    Args:
        predict: actions (robots, 2) in m/s and rad/s for observations (robots, observation size).
        config: of the task and the number of pairs.
    """
    robots = make_validation_robots(config)

    def rate() -> tuple[float, float]:
        found = validate(robots, predict, config)
        # Of one pair or more: there are rates.
        return cast("float", found.success_rate.value), cast("float", found.collision_rate.value)

    return rate


def table(peers: Iterable[PeerRun]) -> str:
    """Runs as Markdown, the fastest first, then those that the limit ended, the best first."""
    done = sorted(peers, key=lambda peer: (not peer.is_reached, peer.minutes if peer.is_reached else -peer.best))
    return markdown([*COLUMNS, "success", "best", "collisions"], [_row(peer) for peer in done])


def _row(peer: PeerRun) -> list[str]:
    last = peer.evaluations[-1]
    minutes = f"{peer.minutes:.1f}" if peer.is_reached else f"{peer.minutes:.1f}, not reached"
    clocks = [minutes, f"{last.wall_seconds / 60:.1f}"]
    counts = [str(last.steps), str(peer.updates), f"{last.steps / last.training_seconds:.0f}"]
    rates = [f"{each:.2f}" for each in (last.success_rate, peer.best, last.collision_rate)]
    return [peer.task, peer.algorithm, peer.setting, str(peer.seed), *clocks, *counts, *rates]
