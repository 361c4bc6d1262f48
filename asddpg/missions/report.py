"""A row a mission, as text and in missions.csv."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asddpg.atomic_write import write_whole
from asddpg.episodes.intervals import rate
from asddpg.missions.log import MissionLog

COLUMNS = (
    "mission", "outcome", "reached", "targets", "seconds", "path_m", "error_median_m", "error_q95_m", "error_max_m",
    "heading_median_deg", "failure",
)  # fmt: skip


@dataclass(frozen=True)
class MissionRow:
    """Figures of a mission; errors are those of the estimated pose."""

    number: int
    outcome: str
    reached: int
    targets: int
    seconds: float
    path: float  # m
    errors: tuple[float, float, float]  # m: median, 95 % and largest
    heading: float  # degrees, median
    failure: str  # its reason; empty for a mission that succeeded

    @classmethod
    def of_log(cls, log: MissionLog, number: int, control_timestep: float, failure: str) -> "MissionRow":
        """The figures of a log."""
        middle, most, largest = np.quantile(log.errors, (0.5, 0.95, 1.0)).tolist()
        return cls(
            number,
            log.outcome,
            len(log.arrivals),
            len(log.mission.targets),
            (len(log.poses) - 1) * control_timestep,
            log.path_length,
            (middle, most, largest),
            float(np.degrees(np.median(log.heading_errors))),
            failure,
        )

    def describe(self) -> str:
        """One line."""
        result = self.failure or "all targets reached, nothing touched"
        way = f"{self.reached} of {self.targets} targets in {self.seconds:.0f} s and {self.path:.1f} m"
        return (
            f"mission {self.number}: {result}; {way}; estimate {self.errors[0]:.3f} m off, {self.errors[2]:.2f} at most"
        )


def summarize(rows: Sequence[MissionRow]) -> str:
    """How many missions succeeded, with the 95 % interval."""
    succeeded = sum(not row.failure for row in rows)
    share = rate(succeeded, len(rows))
    reached, targets = sum(row.reached for row in rows), sum(row.targets for row in rows)
    return (
        f"{succeeded} of {len(rows)} missions succeeded, {share.value:.2f} [{share.low:.2f}, {share.high:.2f}]; "
        f"{reached} of {targets} targets reached"
    )


def write_rows(rows: Sequence[MissionRow], path: Path) -> None:
    """Write missions.csv."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in rows:
        figures = [row.seconds, row.path, *row.errors, row.heading]
        numbers = [f"{figure:.3f}" for figure in figures]
        writer.writerow([row.number, row.outcome, row.reached, row.targets, *numbers, row.failure])
    write_whole(path, text.getvalue().encode())
