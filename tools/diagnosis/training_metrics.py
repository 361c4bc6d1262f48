"""Metrics of a training from its logs: a row an episode in metrics.csv, a row a step in steps.npz."""

import csv
import io
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from asddpg.errors import UserError
from tasks.physics import FloatArray
from tools.diagnosis.step_metrics import (
    WINDOWS,
    ByDistance,
    Cell,
    Preferred,
    bin_centres,
    read_steps,
    shares_by_distance,
    shares_by_place,
    shares_over_training,
)

COLUMNS = ("step", "steps", "controller_share", "td_error_policy", "td_error_controller")
EPISODES = 5  # a window, at least, on average


@dataclass(frozen=True)
class Windows:
    """Means over windows of training, and the step at each window's centre; None in a window without values.

    `driven` is the controller's share of the steps; `td_policy` and `td_controller` are mean |y^A − Q^A|.
    """

    steps: list[float]
    driven: list[float | None]
    td_policy: list[float | None]
    td_controller: list[float | None]


@dataclass(frozen=True)
class TrainingMetrics:
    """Metrics of a training; all but `windows` are empty without a step log or a controller."""

    windows: Windows
    preferred: Preferred = field(default_factory=Preferred)
    by_distance: list[ByDistance] = field(default_factory=list)
    by_place: list[Cell] = field(default_factory=list)


def read_training_metrics(metrics: Path, steps: Path | None) -> TrainingMetrics:
    """Read metrics.csv and, if given, steps.npz.

    Raises:
        UserError: a file is missing or damaged.
    """
    windows = read_windows(metrics)
    if steps is None:
        return TrainingMetrics(windows)
    log = read_steps(steps)
    return TrainingMetrics(windows, shares_over_training(log), shares_by_distance(log), shares_by_place(log))


def read_windows(metrics: Path) -> Windows:
    """Means over training from metrics.csv; missing columns are None throughout.

    Raises:
        UserError: the file is missing or damaged.
    """
    try:
        # A row that a training in progress is writing has no end of line yet.
        whole, _, _ = metrics.read_text(encoding="utf-8").rpartition("\n")
        rows = list(csv.DictReader(io.StringIO(whole)))
        columns = {name: np.array([float(row.get(name) or "nan") for row in rows]) for name in COLUMNS}
        if not np.isfinite([columns["step"], columns["steps"]]).all():
            raise ValueError("a row has no steps")
    except OSError as error:
        raise UserError(f"{metrics} cannot be read: {error.strerror}") from error
    except (csv.Error, ValueError, TypeError) as error:
        raise UserError(f"{metrics} is damaged or not written by asddpg.train") from error
    ends, lengths, *others = columns.values()
    total = ends[-1] if len(ends) else 0.0
    windows = min(WINDOWS, max(len(rows) // EPISODES, 1))
    window = ((ends - lengths / 2) * windows / max(total, 1.0)).astype(int)
    return Windows(bin_centres(total, windows), *(_means(values, lengths, window, windows) for values in others))


def _means(values: FloatArray, weights: FloatArray, part: npt.NDArray[np.intp], parts: int) -> list[float | None]:
    """Weighted mean of the finite values in each part, None without any."""
    known = np.isfinite(values)
    sums = np.bincount(part[known], weights=(values * weights)[known], minlength=parts)
    totals = np.bincount(part[known], weights=weights[known], minlength=parts)
    return [float(s / t) if t else None for s, t in zip(sums, totals, strict=True)]
