"""Figures of a training from its logs: who drove and whom the switch preferred, by time, place, distance; TD errors.

The schedule (agent.withdrawal) withdraws the controller whatever the switch says, so the two are told apart: `driven`,
the steps that the controller drove, and `preferred`, those where the switch valued it above the policy.
"""

import csv
import io
import math
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from asddpg.errors import UserError

FloatArray = npt.NDArray[np.float64]
StepArrays = Mapping[str, npt.NDArray[np.float32]]

WINDOWS = 40  # of training, at most
EPISODES = 5  # in a window, at least, on the average
QUARTERS = 4
DISTANCE_BIN = 0.5  # m
CELL = 0.4  # m, of the map
FEWEST = 10  # steps, below which a share is not told
NEEDED = ("x", "y", "distance", "by_controller", "q_policy", "q_controller")  # of steps.npz


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
class Preferred:
    """Share of the steps at which the switch preferred the controller; the step in each window's middle."""

    steps: list[float]
    shares: list[float]


@dataclass(frozen=True)
class ByDistance:
    """The controller's shares in a quarter of training, by distance to the goal; metres to each bin's middle."""

    quarter: int  # from 1
    distances: list[float]
    driven: list[float]
    preferred: list[float]


@dataclass(frozen=True)
class Cell:
    """A square of the floor, `CELL` wide, by its middle (m): steps there, and the controller's shares of them."""

    x: float
    y: float
    steps: int
    driven: float
    preferred: float


@dataclass(frozen=True)
class Training:
    """All that is told of a training; what needs a step log and a controller is empty where there is none."""

    windows: Windows
    preferred: Preferred
    by_distance: list[ByDistance]
    by_place: list[Cell]


def training_of(metrics: Path, steps: Path | None) -> Training:
    """Figures of metrics.csv and, if given, of steps.npz.

    Raises:
        UserError: a file is missing or damaged.
    """
    windows = windows_of(metrics)
    if steps is None:
        return Training(windows, Preferred([], []), [], [])
    log = read_steps(steps)
    return Training(windows, shares_over_training(log), shares_by_distance(log), shares_by_place(log))


# metrics.csv ------------------------------------------------------------------------------------------------------


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
        _middles(total, windows), means("controller_share"), means("td_error_policy"), means("td_error_controller")
    )


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def _middles(total: float, windows: int) -> list[float]:
    """Steps in the windows' middles."""
    middles: list[float] = ((np.arange(windows) + 0.5) * total / windows).tolist()
    return middles


def _means(values: FloatArray, weights: FloatArray, part: npt.NDArray[np.intp], parts: int) -> list[float | None]:
    """Weighted means of the values in each part, None where there are none."""
    known = np.isfinite(values)
    sums = np.bincount(part[known], weights=(values * weights)[known], minlength=parts)
    totals = np.bincount(part[known], weights=weights[known], minlength=parts)
    return [float(s / t) if t else None for s, t in zip(sums, totals, strict=True)]


# steps.npz --------------------------------------------------------------------------------------------------------


def read_steps(path: Path) -> StepArrays:
    """The arrays of steps.npz that figures are made of.

    Raises:
        UserError: the file is damaged.
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return _alike({name: arrays[name] for name in NEEDED})
    except (
        zipfile.BadZipFile,
        zlib.error,
        EOFError,
        OSError,
        ValueError,
        KeyError,
        TypeError,
        AttributeError,
    ) as error:
        raise UserError(
            f"{path} is damaged or not written by asddpg.train; move it away and the rest is diagnosed"
        ) from error


def _alike(steps: StepArrays) -> StepArrays:
    if len({array.shape for array in steps.values()}) > 1:
        raise ValueError("a step is a row in each array")
    return steps


def _preferred(steps: StepArrays) -> npt.NDArray[np.bool_]:
    """Where the switch preferred the controller, whether or not the controller was allowed to drive."""
    preferred: npt.NDArray[np.bool_] = steps["q_controller"] > steps["q_policy"]
    return preferred


def shares_over_training(steps: StepArrays) -> Preferred:
    """How often the switch preferred the controller, in windows of training."""
    parts = [part for part in np.array_split(_preferred(steps), WINDOWS) if len(part)]
    return Preferred(_middles(len(steps["x"]), len(parts)), [float(part.mean()) for part in parts])


def shares_by_distance(steps: StepArrays) -> list[ByDistance]:
    """The controller's shares by distance to the goal in each quarter of training."""
    distance, driven, preferred = steps["distance"], steps["by_controller"], _preferred(steps)
    edges = np.array_split(np.arange(len(distance)), QUARTERS)
    found = []
    for number, rows in enumerate(edges, start=1):
        part = (distance[rows] / DISTANCE_BIN).astype(int)
        counts = np.bincount(part)
        told = np.flatnonzero(counts >= FEWEST)
        shares = [(np.bincount(part, weights=of[rows])[told] / counts[told]).tolist() for of in (driven, preferred)]
        found.append(ByDistance(number, ((told + 0.5) * DISTANCE_BIN).tolist(), *shares))
    return found


def shares_by_place(steps: StepArrays) -> list[Cell]:
    """The controller's shares by place, in the last quarter of training, where enough steps were made."""
    last = slice(len(steps["x"]) * (QUARTERS - 1) // QUARTERS, None)
    places = np.stack([steps["x"][last], steps["y"][last]], axis=1).astype(np.float64)
    cells, part, counts = np.unique(np.floor(places / CELL), axis=0, return_inverse=True, return_counts=True)
    driven, preferred = (
        np.bincount(part.ravel(), weights=of[last], minlength=len(counts)) / counts
        for of in (steps["by_controller"], _preferred(steps))
    )
    middles = (cells + 0.5) * CELL
    return [
        Cell(round(x, 3), round(y, 3), int(count), float(drove), float(wished))
        for (x, y), count, drove, wished in zip(middles.tolist(), counts, driven, preferred, strict=True)
        if count >= FEWEST
    ]
