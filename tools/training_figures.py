"""Figures of a training from its logs: the controller's share over time, place and distance; TD errors by origin."""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

WINDOWS = 40  # of training, at most
EPISODES = 5  # in a window, at least, on the average
QUARTERS = 4
DISTANCE_BIN = 0.5  # m
CELL = 0.4  # m, of the map
FEWEST = 10  # steps, below which a share is not told


@dataclass(frozen=True)
class Windows:
    """Figures over training: the step in each window's middle, and each figure's mean in it, None where there is none.

    `shares` is the controller's; `td_policy` and `td_controller` are mean |y^A − Q^A|.
    """

    steps: list[float]
    shares: list[float | None]
    td_policy: list[float | None]
    td_controller: list[float | None]


@dataclass(frozen=True)
class ByDistance:
    """The controller's share in a quarter of training, by distance to the goal; metres to each bin's middle."""

    quarter: int  # from 1
    distances: list[float]
    shares: list[float]


@dataclass(frozen=True)
class Cell:
    """A square of the floor, `CELL` wide, by its middle (m): steps there, and the controller's share of them."""

    x: float
    y: float
    steps: int
    share: float


def windows_of(metrics: Path) -> Windows:
    """Figures over training from metrics.csv; columns that an older run lacks are None throughout."""
    with metrics.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    ends, lengths = (np.array([float(row[name]) for row in rows]) for name in ("step", "steps"))
    total = ends[-1] if len(ends) else 0.0
    windows = min(WINDOWS, max(len(rows) // EPISODES, 1))
    window = ((ends - lengths / 2) * windows / max(total, 1.0)).astype(int)

    def means(name: str) -> list[float | None]:
        values = np.array([float(row.get(name) or "nan") for row in rows])
        return _means(values, lengths, window, windows)

    middles = ((np.arange(windows) + 0.5) * total / windows).tolist()
    return Windows(middles, means("controller_share"), means("td_error_policy"), means("td_error_controller"))


def _means(values: FloatArray, weights: FloatArray, part: npt.NDArray[np.intp], parts: int) -> list[float | None]:
    """Weighted means of the values in each part, None where there are none."""
    known = np.isfinite(values)
    sums = np.bincount(part[known], weights=(values * weights)[known], minlength=parts)
    totals = np.bincount(part[known], weights=weights[known], minlength=parts)
    return [float(s / t) if t else None for s, t in zip(sums, totals, strict=True)]


def shares_by_distance(steps: Mapping[str, npt.NDArray[np.float32]]) -> list[ByDistance]:
    """The controller's share by distance to the goal in each quarter of training, from the arrays of steps.npz."""
    distance, driven = steps["distance"], steps["by_controller"]
    edges = np.array_split(np.arange(len(distance)), QUARTERS)
    found = []
    for number, rows in enumerate(edges, start=1):
        part = (distance[rows] / DISTANCE_BIN).astype(int)
        counts = np.bincount(part)
        told = np.flatnonzero(counts >= FEWEST)
        shares = np.bincount(part, weights=driven[rows])[told] / counts[told]
        found.append(ByDistance(number, ((told + 0.5) * DISTANCE_BIN).tolist(), shares.tolist()))
    return found


def shares_by_place(steps: Mapping[str, npt.NDArray[np.float32]]) -> list[Cell]:
    """The controller's share by place, in the last quarter of training, where enough steps were made."""
    last = slice(len(steps["x"]) * (QUARTERS - 1) // QUARTERS, None)
    places = np.stack([steps["x"][last], steps["y"][last]], axis=1).astype(np.float64)
    cells, part, counts = np.unique(np.floor(places / CELL), axis=0, return_inverse=True, return_counts=True)
    shares = np.bincount(part.ravel(), weights=steps["by_controller"][last], minlength=len(counts)) / counts
    middles = (cells + 0.5) * CELL
    return [
        Cell(round(x, 3), round(y, 3), int(count), float(share))
        for (x, y), count, share in zip(middles.tolist(), counts, shares, strict=True)
        if count >= FEWEST
    ]
