"""The controller's share of a training from its log of steps, by time, distance and place.

The schedule (agent.withdrawal) withdraws the controller whatever the switch prefers, so there are two shares: `driven`,
steps that the controller drove, and `preferred`, steps where the switch rated it above the policy.
"""

import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from asddpg.errors import UserError
from asddpg.runs.safe_loading import check_packed

StepArrays = Mapping[str, npt.NDArray[np.float32]]

WINDOWS = 40  # of training, at most
QUARTERS = 4
DISTANCE_BIN = 0.5  # m
CELL = 0.4  # m, of the map
MIN_COUNT = 10  # steps, below which there is no share
MAX_UNPACKED_BYTES = 4 * 10**9  # bytes that steps.npz may unpack to; ten million steps are a fourth of it
_DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    OSError,
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    MemoryError,
)
NEEDED = ("x", "y", "distance", "by_controller", "q_policy", "q_controller")  # arrays of steps.npz


@dataclass(frozen=True)
class Preferred:
    """Share of the steps at which the switch preferred the controller, and the step at each window's centre."""

    steps: list[float]
    shares: list[float]


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
    """The arrays of steps.npz that metrics need.

    Raises:
        UserError: the file is damaged.
    """
    try:
        check_packed(path, MAX_UNPACKED_BYTES)
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            steps = {name: arrays[name] for name in NEEDED}
            if len({array.shape for array in steps.values()}) > 1:
                raise ValueError("the arrays differ in length")
            return steps
    except _DAMAGE as error:
        raise UserError(
            f"{path} is damaged or not written by asddpg.train; move it away and the rest is diagnosed"
        ) from error


def _preferred(steps: StepArrays) -> npt.NDArray[np.bool_]:
    """Whether the switch rated the controller above the policy, (steps,)."""
    preferred: npt.NDArray[np.bool_] = steps["q_controller"] > steps["q_policy"]
    return preferred


def shares_over_training(steps: StepArrays) -> Preferred:
    """Share of the steps at which the switch preferred the controller, by windows of training."""
    parts = [part for part in np.array_split(_preferred(steps), WINDOWS) if len(part)]
    return Preferred(bin_centres(len(steps["x"]), len(parts)), [float(part.mean()) for part in parts])


def shares_by_distance(steps: StepArrays) -> list[ByDistance]:
    """The controller's shares by distance to the goal in each quarter of training."""
    distance, driven, preferred = steps["distance"], steps["by_controller"], _preferred(steps)
    edges = np.array_split(np.arange(len(distance)), QUARTERS)
    found = []
    for number, rows in enumerate(edges, start=1):
        part = (distance[rows] / DISTANCE_BIN).astype(int)
        counts = np.bincount(part)
        shown = np.flatnonzero(counts >= MIN_COUNT)
        shares = [
            (np.bincount(part, weights=values[rows])[shown] / counts[shown]).tolist() for values in (driven, preferred)
        ]
        found.append(ByDistance(number, ((shown + 0.5) * DISTANCE_BIN).tolist(), *shares))
    return found


def shares_by_place(steps: StepArrays) -> list[Cell]:
    """The controller's shares by place in the last quarter of training, in cells with MIN_COUNT steps or more."""
    last = slice(len(steps["x"]) * (QUARTERS - 1) // QUARTERS, None)
    places = np.stack([steps["x"][last], steps["y"][last]], axis=1).astype(np.float64)
    cells, part, counts = np.unique(np.floor(places / CELL), axis=0, return_inverse=True, return_counts=True)
    driven, preferred = (
        np.bincount(part.ravel(), weights=values[last], minlength=len(counts)) / counts
        for values in (steps["by_controller"], _preferred(steps))
    )
    centres = (cells + 0.5) * CELL
    return [
        Cell(round(x, 3), round(y, 3), int(count), float(drove), float(prefers))
        for (x, y), count, drove, prefers in zip(centres.tolist(), counts, driven, preferred, strict=True)
        if count >= MIN_COUNT
    ]


def bin_centres(total: float, windows: int) -> list[float]:
    """Training steps at the centres of equal windows."""
    centres: list[float] = ((np.arange(windows) + 0.5) * total / windows).tolist()
    return centres
