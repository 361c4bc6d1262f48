"""A row an episode, to metrics.csv, and the same figures to TensorBoard."""

import csv
import math
import time
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol, SupportsFloat, TextIO

from asddpg.atomic_write import closed_on_error
from asddpg.episodes.protocols import Episode, Observation, Step

WINDOW = 100  # episodes

COLUMNS = (
    "step", "episode", "outcome", "steps", "total_reward", "path_length", "controller_share",
    "success_100", "collision_100", "timeout_100", "critic_loss", "switch_loss", "policy_loss",
    "td_error_policy", "td_error_controller",
)  # fmt: skip


class ScalarWriter(Protocol):
    """The part of TensorBoard's SummaryWriter that is used."""

    def add_scalar(self, tag: str, scalar_value: float, global_step: int) -> None:
        """Write one figure."""


class RecentEpisodes:
    """Shares of outcomes among the last WINDOW episodes."""

    def __init__(self, outcomes: Iterable[str] = ()) -> None:
        """Go on after episodes that ended so, oldest first."""
        self._outcomes: deque[str] = deque(outcomes, maxlen=WINDOW)

    def add(self, outcome: str) -> None:
        """Count an episode."""
        self._outcomes.append(outcome)

    def share(self, outcome: str) -> float:
        """Share of the recent episodes that ended so."""
        return self._outcomes.count(outcome) / len(self._outcomes) if self._outcomes else 0.0


class MetricsLog:
    """Writes metrics.csv, in which nothing depends on the clock, and timing.csv; goes on where they end."""

    def __init__(self, metrics: Path, timing: Path, tensorboard: ScalarWriter, seconds: float = 0.0) -> None:
        """Open the files.

        Args:
            metrics: path of metrics.csv.
            timing: path of timing.csv.
            tensorboard: gets the same figures.
            seconds: that the training had taken before.
        """
        before = read_rows(metrics)
        self._recent = RecentEpisodes(row["outcome"] for row in before)
        self._steps, self._episodes = int(before[-1]["step"]) if before else 0, len(before)
        self._metrics_file, self._metrics = _appended(metrics, COLUMNS)
        with closed_on_error(self._metrics_file):
            self._timing_file, self._timing = _appended(timing, ("step", "seconds", "steps_per_second"))
        self._tensorboard = tensorboard
        self._learned: dict[str, list[SupportsFloat]] = {}
        self._begun = time.perf_counter() - seconds

    @property
    def seconds(self) -> float:
        """What the training has taken so far."""
        return time.perf_counter() - self._begun

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
        seconds = self.seconds
        self._timing.writerow((self._steps, f"{seconds:.3f}", f"{self._steps / seconds:.1f}"))
        self._timing_file.flush()

    def _means(self) -> dict[str, float]:
        """Means over the updates that had the figure: a TD error is nan where a batch had no sample of that driver."""
        known = {name: [v for v in map(float, values) if not math.isnan(v)] for name, values in self._learned.items()}
        return {name: sum(values) / len(values) for name, values in known.items() if values}

    def close(self) -> None:
        """Close the files."""
        try:
            self._metrics_file.close()
        finally:
            self._timing_file.close()


def read_rows(path: Path) -> list[dict[str, str]]:
    """The rows of a table that a training writes; none where there is no file yet."""
    if not path.is_file():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _appended(path: Path, columns: Sequence[str]) -> tuple[TextIO, Any]:
    """A table to add rows to, with its first line if it is new."""
    file = path.open("a", newline="", encoding="utf-8")
    table = csv.writer(file)
    with closed_on_error(file):
        if not file.tell():
            table.writerow(columns)
            file.flush()
    return file, table


_WINDOWED = {"success": "reached", "collision": "crashed", "timeout": "timeout"}
