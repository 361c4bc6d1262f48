"""The controller's share of a training from its log of steps, by time, distance and place.

The schedule (agent.withdrawal) withdraws the controller whatever the switch prefers, so there are two shares: `driven`,
steps that the controller drove, and `preferred`, steps where the switch rated it above the policy.
"""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from asddpg.errors import UserError
from asddpg.runs.safe_loading import check_packed

StepArrays = Mapping[str, npt.NDArray[Any]]  # by name, each (steps,)

WINDOWS = 40  # of training, at most
QUARTERS = 4
DISTANCE_BIN = 0.5  # m
CELL = 0.4  # m, of the map
MIN_COUNT = 10  # steps, below which there is no share
MAX_UNPACKED_BYTES = 4 * 10**9  # bytes that steps.npz may unpack to; ten million steps are a fourth of it
DAMAGE = (BadZipFile, zlib.error, EOFError, OSError, ValueError, LookupError, TypeError, AttributeError, MemoryError)
NEEDED = ("x", "y", "distance", "by_controller", "q_policy", "q_controller")  # arrays of steps.npz


@dataclass(frozen=True)
class Preferred:
    """Share of the steps at which the switch preferred the controller, and the step at each window's centre."""

    steps: list[float] = field(default_factory=list)
    shares: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class ByDistance:
    """The controller's shares in a quarter of training, by distance to the goal: bin centres in metres."""

    quarter: int  # from 1
    distances: list[float]
    driven: list[float]
    preferred: list[float]


@dataclass(frozen=True)
class Cell:
    """A square of the floor, `CELL` wide, with its centre (m), the steps in it, and the controller's shares of them."""

    x: float
    y: float
    steps: int
    driven: float
    preferred: float


def read_steps(path: Path) -> StepArrays:
    """The columns of steps.npz that the metrics need, and `preferred`: whether the switch rated the controller higher.

    Raises:
        UserError: the file is damaged.
    """
    try:
        steps = read_columns(path, NEEDED)
    except DAMAGE as error:
        raise UserError(
            f"{path} is damaged or not written by asddpg.train; move it away and the rest is diagnosed"
        ) from error
    return {**steps, "preferred": steps["q_controller"] > steps["q_policy"]}


def read_columns(path: Path, names: Sequence[str]) -> StepArrays:
    """Columns of steps.npz; an exception of DAMAGE where it is damaged."""
    check_packed(path, MAX_UNPACKED_BYTES)
    # Opened here: of a damaged one np.load leaves its own open.
    with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
        steps = {name: arrays[name] for name in names}
    if len({array.shape for array in steps.values()}) > 1:
        raise ValueError("the arrays differ in length")
    return steps


def shares_over_training(steps: StepArrays) -> Preferred:
    """Share of the steps at which the switch preferred the controller, by windows of training."""
    count = len(steps["preferred"])
    parts = np.array_split(steps["preferred"], min(WINDOWS, count)) if count else []
    return Preferred(bin_centres(count, len(parts)), [float(part.mean()) for part in parts])


def shares_by_distance(steps: StepArrays) -> list[ByDistance]:
    """The controller's shares by distance to the goal in each quarter of training."""
    found = []
    for quarter, rows in enumerate(np.array_split(np.arange(len(steps["distance"])), QUARTERS), start=1):
        bins, _, *shares = _shares(np.floor(steps["distance"][rows] / DISTANCE_BIN), steps, rows)
        found.append(ByDistance(quarter, ((bins + 0.5) * DISTANCE_BIN).tolist(), *shares))
    return found


def shares_by_place(steps: StepArrays) -> list[Cell]:
    """The controller's shares by place in the last quarter of training, in cells with MIN_COUNT steps or more."""
    rows = np.arange(len(steps["x"]) * (QUARTERS - 1) // QUARTERS, len(steps["x"]))
    places = np.stack([steps["x"][rows], steps["y"][rows]], axis=1).astype(np.float64)
    cells, counts, driven, preferred = _shares(np.floor(places / CELL), steps, rows)
    x, y = ((cells + 0.5) * CELL).round(3).T.tolist()
    return list(map(Cell, x, y, counts, driven, preferred))


def _shares(
    groups: npt.NDArray[Any], steps: StepArrays, rows: npt.NDArray[np.intp]
) -> tuple[npt.NDArray[Any], list[int], list[float], list[float]]:
    """The groups of rows that have MIN_COUNT of them, their numbers of rows, and the shares driven and preferred."""
    found, group, counts = np.unique(groups, axis=0, return_inverse=True, return_counts=True)
    shown = counts >= MIN_COUNT
    driven, preferred = (
        (np.bincount(group.ravel(), weights=steps[name][rows], minlength=len(counts)) / counts)[shown].tolist()
        for name in ("by_controller", "preferred")
    )
    return found[shown], counts[shown].tolist(), driven, preferred


def bin_centres(total: float, windows: int) -> list[float]:
    """Training steps at the centres of equal windows."""
    centres: list[float] = ((np.arange(windows) + 0.5) * total / windows).tolist()
    return centres
