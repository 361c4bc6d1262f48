"""Figures of a training from its logs: a row an episode in metrics.csv, a row a step in steps.npz."""

import csv
import io
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from asddpg.errors import UserError
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

FloatArray = npt.NDArray[np.float64]

EPISODES = 5  # in a window, at least, on the average


@dataclass(frozen=True)
class Windows:
    """Figures over training: the step in each window's middle, and each figure's mean in it, None where there is none.

    `driven` is the controller's share of the steps; `td_policy` and `td_controller` are mean |y^A − Q^A|.
    """

    steps: list[float]
    driven: list[float | None]
    td_policy: list[float | None]
    td_controller: list[float | None]


@dataclass(frozen=True)
class TrainingMetrics:
    """All that is told of a training; what needs a step log and a controller is empty where there is none."""

    windows: Windows
    preferred: Preferred
    by_distance: list[ByDistance]
    by_place: list[Cell]


def read_training_metrics(metrics: Path, steps: Path | None) -> TrainingMetrics:
    """Figures of metrics.csv and, if given, of steps.npz.

    Raises:
        UserError: a file is missing or damaged.
    """
    windows = windows_of(metrics)
    if steps is None:
        return TrainingMetrics(windows, Preferred([], []), [], [])
    log = read_steps(steps)
    return TrainingMetrics(windows, shares_over_training(log), shares_by_distance(log), shares_by_place(log))


def windows_of(metrics: Path) -> Windows:
    """Figures over training from metrics.csv; columns that an older run lacks are None throughout.

    Raises:
        UserError: the file is missing or damaged.
    """
    try:
        return _windows(_finished_rows(metrics))
    except OSError as error:
        raise UserError(f"{metrics} cannot be read: {error.strerror}") from error
    except (csv.Error, ValueError, TypeError, KeyError) as error:
        raise UserError(f"{metrics} is damaged or not written by asddpg.train") from error


def _finished_rows(metrics: Path) -> list[dict[str, str]]:
    """Without the row that a training in progress is just writing: it has no end of line yet."""
    whole, _, _ = metrics.read_text(encoding="utf-8").rpartition("\n")
    return list(csv.DictReader(io.StringIO(whole)))


def _windows(rows: list[dict[str, str]]) -> Windows:
    ends, lengths = (np.array([_finite(row[name]) for row in rows]) for name in ("step", "steps"))
    total = ends[-1] if len(ends) else 0.0
    windows = min(WINDOWS, max(len(rows) // EPISODES, 1))
    window = ((ends - lengths / 2) * windows / max(total, 1.0)).astype(int)

    def means(name: str) -> list[float | None]:
        values = np.array([float(row.get(name) or "nan") for row in rows])
        return _means(values, lengths, window, windows)

    return Windows(
        bin_centres(total, windows), means("controller_share"), means("td_error_policy"), means("td_error_controller")
    )


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def _means(values: FloatArray, weights: FloatArray, part: npt.NDArray[np.intp], parts: int) -> list[float | None]:
    """Weighted means of the values in each part, None where there are none."""
    known = np.isfinite(values)
    sums = np.bincount(part[known], weights=(values * weights)[known], minlength=parts)
    totals = np.bincount(part[known], weights=weights[known], minlength=parts)
    return [float(s / t) if t else None for s, t in zip(sums, totals, strict=True)]


# steps.npz --------------------------------------------------------------------------------------------------------
