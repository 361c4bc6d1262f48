"""A row an episode to metrics.csv, a row a validation to validation.csv, and the same figures to TensorBoard."""

import csv
import math
import time
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol, SupportsFloat, TextIO

import numpy as np

from asddpg.atomic_write import closed_on_error
from asddpg.episodes.batch_steps import Steps
from asddpg.episodes.protocols import Episode
from asddpg.episodes.training_episodes import Learned, TrainingObserver

WINDOW = 100  # episodes
CUT = "cut"

COLUMNS = (
    "step", "episode", "outcome", "steps", "total_reward", "path_length", "controller_share",
    "success_100", "collision_100", "timeout_100", "critic_loss", "switch_loss", "policy_loss",
    "td_error_policy", "td_error_controller",
)  # fmt: skip
VALIDATION_COLUMNS = ("step", "success_rate", "collision_rate", "metric")


class ScalarWriter(Protocol):
    """The part of TensorBoard's SummaryWriter that is used."""

    def add_scalar(self, tag: str, scalar_value: float, global_step: int) -> None:
        """Write one figure."""


class RecentOutcomes(deque[str]):
    """Outcomes of the last WINDOW episodes."""

    def __init__(self, outcomes: Iterable[str] = ()) -> None:
        """Go on after episodes that ended so, oldest first."""
        super().__init__((each for each in outcomes if each != CUT), WINDOW)

    def append(self, outcome: str) -> None:
        """Add one; an episode that the end of a training cut has none."""
        if outcome != CUT:
            super().append(outcome)

    def share(self, outcome: str) -> float:
        """Share of the recent episodes that ended so."""
        return self.count(outcome) / len(self) if self else 0.0


class MetricsLog(TrainingObserver):
    """Writes metrics.csv, in which nothing depends on the clock, and timing.csv; appends to existing ones."""

    def __init__(self, metrics: Path, timing: Path, tensorboard: ScalarWriter, seconds: float = 0.0) -> None:
        """Open the files.

        Args:
            metrics: path of metrics.csv.
            timing: path of timing.csv.
            tensorboard: gets the same figures.
            seconds: that the training had taken before.
        """
        before = read_rows(metrics)
        self._recent = RecentOutcomes(row["outcome"] for row in before)
        self._steps = int(before[-1]["step"]) if before else 0
        self._metrics_file, self._metrics = _appended(metrics, COLUMNS)
        with closed_on_error(self._metrics_file):
            self._timing_file, self._timing = _appended(timing, ("step", "seconds", "steps_per_second"))
        self._tensorboard = tensorboard
        self._learned: dict[str, list[SupportsFloat]] = {}  # since the step of the last row
        self._is_written = False  # in a row
        self._begun = time.perf_counter() - seconds

    @property
    def seconds(self) -> float:
        """What the training has taken so far."""
        return time.perf_counter() - self._begun

    def state(self) -> dict[str, Any]:
        """What was learned since the step of the last row, and the training steps so far."""
        learned = {name: np.array(list(map(float, values))) for name, values in self._learned.items()}
        return {"learned": learned, "is_written": self._is_written, "steps": self._steps}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Go on in the middle of episodes, with what state() returned."""
        self._learned = {name: values.tolist() for name, values in state["learned"].items()}
        self._is_written, self._steps = state["is_written"], state["steps"]

    def step(self, steps: Steps, learned: Learned) -> None:
        """Keep what was learned; reading a value here would make a GPU wait."""
        self._steps += len(steps.rewards)
        if self._is_written:
            self._learned, self._is_written = {}, False
        for update in learned:
            for name, value in update.items():
                self._learned.setdefault(name, []).append(value)

    def end_episode(self, robot: int, number: int, episode: Episode) -> None:
        """Write the row; what was learned is that since the step of the last one, of any robot."""
        self._recent.append(episode.outcome)
        row: dict[str, Any] = {
            "step": self._steps,
            "episode": number,
            "outcome": episode.outcome,
            "steps": episode.steps,
            "total_reward": episode.total_reward,
            "path_length": episode.path_length,
            "controller_share": episode.controller_share,
            "success_100": self._recent.share("reached"),
            "collision_100": self._recent.share("crashed"),
            "timeout_100": self._recent.share("timeout"),
            **self._means(),
        }
        self._metrics.writerow([row.get(column, "") for column in COLUMNS])
        self._metrics_file.flush()
        self._is_written = True
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


def write_validation(path: Path, tensorboard: ScalarWriter, row: Mapping[str, float]) -> None:
    """Add a row of VALIDATION_COLUMNS."""
    file, table = _appended(path, VALIDATION_COLUMNS)
    with file:
        table.writerow([row[column] for column in VALIDATION_COLUMNS])
    for name in VALIDATION_COLUMNS[1:]:
        tensorboard.add_scalar(f"validation/{name}", row[name], int(row["step"]))


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
