"""A row an episode, to metrics.csv, and the same figures to TensorBoard."""

import csv
import math
import time
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol, SupportsFloat, TextIO

from asddpg.types import Episode, Observation, Step

WINDOW = 100  # episodes

COLUMNS = (
    "step", "episode", "outcome", "steps", "total_reward", "path_length", "controller_share",
    "reach_100", "crash_100", "timeout_100", "critic_loss", "switch_loss", "policy_loss",
    "td_error_policy", "td_error_controller",
)  # fmt: skip


class ScalarWriter(Protocol):
    """The part of TensorBoard's SummaryWriter that is used."""

    def add_scalar(self, tag: str, scalar_value: float, global_step: int) -> None:
        """Write one figure."""


class RecentEpisodes:
    """Shares of outcomes among the last WINDOW episodes."""

    def __init__(self) -> None:
        self._outcomes: deque[str] = deque(maxlen=WINDOW)

    def add(self, outcome: str) -> None:
        """Count an episode."""
        self._outcomes.append(outcome)

    def share(self, outcome: str) -> float:
        """Share of the recent episodes that ended so."""
        return self._outcomes.count(outcome) / len(self._outcomes) if self._outcomes else 0.0


class MetricsLog:
    """Writes metrics.csv, in which nothing depends on the clock, and timing.csv."""

    def __init__(self, metrics: Path, timing: Path, tensorboard: ScalarWriter) -> None:
        self._metrics_file: TextIO = metrics.open("w", newline="", encoding="utf-8")
        self._timing_file: TextIO = timing.open("w", newline="", encoding="utf-8")
        self._metrics = csv.writer(self._metrics_file)
        self._timing = csv.writer(self._timing_file)
        self._metrics.writerow(COLUMNS)
        self._timing.writerow(("step", "seconds", "steps_per_second"))
        self._tensorboard = tensorboard
        self._recent = RecentEpisodes()
        self._steps, self._episodes = 0, 0
        self._learned: dict[str, list[SupportsFloat]] = {}
        self._begun = time.perf_counter()

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Means begin anew."""
        self._learned = {}

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Keep what was learned; to look at a value here would make a GPU wait."""
        self._steps += 1
        for name, value in learned.items():
            self._learned.setdefault(name, []).append(value)

    def end_episode(self, episode: Episode) -> None:
        """Write the row."""
        self._episodes += 1
        self._recent.add(episode.outcome)
        row: dict[str, Any] = {
            "step": self._steps,
            "episode": self._episodes,
            "outcome": episode.outcome,
            "steps": episode.steps,
            "total_reward": episode.total_reward,
            "path_length": episode.path_length,
            "controller_share": episode.controller_share,
            **{f"{outcome}_100": self._recent.share(full) for outcome, full in _WINDOWED.items()},
            **self._means(),
        }
        self._metrics.writerow([row.get(column, "") for column in COLUMNS])
        self._metrics_file.flush()
        for name in COLUMNS[3:]:
            if name in row:
                self._tensorboard.add_scalar(f"train/{name}", row[name], self._steps)
        seconds = time.perf_counter() - self._begun
        self._timing.writerow((self._steps, f"{seconds:.3f}", f"{self._steps / seconds:.1f}"))
        self._timing_file.flush()

    def _means(self) -> dict[str, float]:
        """Means over the updates that had the figure: a TD error is nan where a batch had no sample of that driver."""
        known = {name: [v for v in map(float, values) if not math.isnan(v)] for name, values in self._learned.items()}
        return {name: sum(values) / len(values) for name, values in known.items() if values}

    def close(self) -> None:
        """Close the files."""
        self._metrics_file.close()
        self._timing_file.close()


_WINDOWED = {"reach": "reached", "crash": "crashed", "timeout": "timeout"}
