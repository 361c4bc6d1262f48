"""How well AMCL knows where the robot is: `python -m tools.localization`.

The robot drives through a room, from goal to goal with a planner that knows its true pose. AMCL has the wheels' angles,
with odometry that takes lengths and turns for too long, the laser with its noise, and a map that lacks some obstacles.
Prints the errors of its estimate over all control steps, and writes a row a drive. With start=anywhere it begins
without any idea, and the drives count that end within 0.3 m and stay there for their last five seconds.
"""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asddpg.atomic_write import write_whole
from asddpg.config import NAMES
from asddpg.messages import print_line
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks.options import NOT_NEGATIVE, POSITIVE, between, one_of, option
from tasks.registry import ROOM_TASKS
from tools.comparison.localization_drives import Drive, DriveOptions, drive

FOUND_WITHIN, LAST_SECONDS = 0.3, 5.0  # m, s
LOST_BEYOND = 0.5  # m
BARS = "bars: 0.06 m and 2° in the middle, 0.2 m for 95 %"


@dataclass(frozen=True)
class LocalizationArguments:
    """Where and how the robot drives, and what AMCL knows."""

    drives: int = option(20, "Drives.", between(1, 1000))
    seconds: float = option(60.0, "Length of each, simulated.", POSITIVE)
    task: str = option("nav_office", "The room.", one_of(*ROOM_TASKS))
    unmapped: list[str] = option(
        ["sofa", "copier", "bench", "bookshelf", "carton"], "Obstacles that the map lacks.", NAMES
    )
    noise: float = option(1.0, "Scale of the laser's noise; 1 is that of a real URG-04LX.", NOT_NEGATIVE)
    drift: float = option(0.05, "By how much odometry takes lengths and turns for too long.", between(-0.5, 0.5))
    start: str = option("known", "What AMCL knows at first.", one_of("known", "anywhere"))
    seed: int = option(0, "Of starts, goals, noise and particles.", NOT_NEGATIVE)
    out: Path = option(Path("localization.csv"), "File with a row a drive.")


def main(arguments: Sequence[str]) -> None:
    """Drive, print the errors, write the file."""
    parsed = parse_arguments(LocalizationArguments, arguments)
    options = DriveOptions(
        parsed.task, parsed.seconds, tuple(parsed.unmapped), parsed.noise, parsed.drift, parsed.start == "known"
    )
    driven = []
    for number in range(parsed.drives):
        driven.append(drive(options, parsed.seed + number))
        print_line(f"drive {number + 1}: {_describe(driven[-1])}")
    print_line(_summarize(driven, is_found=parsed.start == "anywhere"))
    _write(driven, parsed.out)
    print_line(f"written to {parsed.out}")


def _describe(each: Drive) -> str:
    median, most = np.quantile(each.distances, (0.5, 1.0))
    heading = np.degrees(np.median(each.angles))
    return f"{len(each.distances)} steps, {median:.3f} m and {heading:.1f}° in the middle, {most:.2f} m at most"


def _summarize(driven: Sequence[Drive], is_found: bool) -> str:
    if is_found:
        found = sum(each.is_found(FOUND_WITHIN, LAST_SECONDS) for each in driven)
        return f"found within {FOUND_WITHIN} m: {found} of {len(driven)} (bar: 16 of 20)"
    distances = np.concatenate([each.distances for each in driven])
    angles = np.degrees(np.concatenate([each.angles for each in driven]))
    lost = sum(each.distances.max() > LOST_BEYOND for each in driven)
    middle, most = np.quantile(distances, (0.5, 0.95))
    return (
        f"position {middle:.3f} m in the middle, 95 % within {most:.3f} m; heading {np.median(angles):.2f}° in the "
        f"middle; lost in {lost} of {len(driven)} drives ({BARS}, never lost)"
    )


def _write(driven: Sequence[Drive], path: Path) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["seed", "steps", "median_m", "q95_m", "max_m", "median_deg", "last_m"])
    for each in driven:
        middle, most, largest = np.quantile(each.distances, (0.5, 0.95, 1.0)).tolist()
        heading = float(np.degrees(np.median(each.angles)))
        numbers = (middle, most, largest, heading, float(each.distances[-1]))
        writer.writerow([each.seed, len(each.distances), *(f"{number:.4f}" for number in numbers)])
    write_whole(path, text.getvalue().encode())


if __name__ == "__main__":
    run(main, help_text(__doc__, LocalizationArguments))
