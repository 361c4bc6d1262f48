"""Drivers side by side: `python -m tools.compare drivers=[controller,pretrained:nav_complex] tasks=[nav_complex]`.

Drives all on the same stored test pairs, two processes at once, and prints and writes one table of their figures and
one of their differences, paired by start and goal. A driver is controller, random, move_base, waypoints,
pretrained:<name>, the folder of a run, pretrained:<name>+waypoints or a folder with +waypoints where a planner leads
it, or your own as package.module:Factory. Each driver on each task is a file in the folder that holds every episode; it
is not driven again, and an interrupted program goes on where it was.
"""

import os
from collections.abc import Sequence
from dataclasses import MISSING, dataclass, field
from pathlib import Path

from asddpg.build import prepare_torch
from asddpg.config import ControllerConfig, PlannerConfig
from asddpg.errors import UserError
from asddpg.messages import print_line
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks import ALL_TASKS
from tasks.options import Range, between, option
from tasks.robots.names import ROBOTS
from tasks.rooms.reading import ROOMS, is_room
from tools.comparison.cases import MOST_ROOMS, Case, expand_rooms
from tools.comparison.driven_episodes import DrivenCase
from tools.comparison.tables import write_tables
from tools.comparison.worker_processes import drive_all

DRIVERS = Range(lambda names: names and len(set(names)) == len(names), "one driver or more, each once")


def _is_place(name: str) -> bool:
    return name in ALL_TASKS or all(map(is_room, expand_rooms(name)))


TASKS = Range(
    lambda names: names and len(set(names)) == len(names) and all(map(_is_place, names)),
    f"one or more of {', '.join(ALL_TASKS)}, each once, {ROOMS}, or up to {MOST_ROOMS} of them such as cylinders:0-49",
)


@dataclass(frozen=True)
class CompareArguments:
    """Who drives where, and with which options."""

    drivers: list[str] = option(MISSING, "Drivers, such as [controller,pretrained:nav_complex].", DRIVERS)
    tasks: list[str] = option(["nav_complex"], "Tasks that each drives.", TASKS)
    episodes: int = option(
        200,
        "Stored test pairs of each task, the first so many.",
        between(1, 1000, ", the size of the stored test set of nav_anywhere; other sets have 200"),
    )
    baseline: str | None = option(
        None, "The driver that the differences are taken against; null takes the first of drivers."
    )
    processes: int = option(2, "Drivers at once, each in a process; 1 drives in this one.", between(1, 256))
    folder: Path = option(Path("runs") / "compare", "Folder of the episodes and the tables.")
    robot: str | None = option(None, f"Of all drivers: {ROBOTS}; null takes a run's own, or the Pioneer.")
    controller: ControllerConfig = field(default_factory=ControllerConfig)
    planner: PlannerConfig = field(default_factory=PlannerConfig)


@prepare_torch()
def main(arguments: Sequence[str]) -> None:
    """Drive what is missing, print and write the tables."""
    parsed = parse_arguments(CompareArguments, arguments)
    baseline, cases, folder = _baseline(parsed), _cases(parsed), parsed.folder
    _make_folder(folder)
    paths = [case.path(folder, case.set_up(folder)) for case in cases]  # a mistake in any is found before one drives
    missing = [case for case, path in zip(cases, paths, strict=True) if not path.exists()]
    print_line(f"{len(missing)} of {len(cases)} to drive; the others are in {folder}")
    drive_all(missing, folder, parsed.processes)
    driven = [part for case, path in zip(cases, paths, strict=True) for part in _read(case, path).split()]
    print_line(f"\n{write_tables(driven, baseline, folder)}\n\nwritten to {folder / 'table.md'} and table.csv")


def _baseline(parsed: CompareArguments) -> str:
    baseline = parsed.baseline or parsed.drivers[0]
    if baseline not in parsed.drivers:
        raise UserError(f"baseline must be one of drivers, {', '.join(parsed.drivers)}, not {baseline!r}")
    return baseline


def _cases(parsed: CompareArguments) -> list[Case]:
    """Every driver on every task; UserError where no driver heeds an option that is given."""
    cases = [
        Case(driver, task, parsed.episodes, parsed.controller, parsed.planner, parsed.robot)
        for task in parsed.tasks
        for driver in parsed.drivers
    ]
    heeded = {name for case in cases for name in case.options}
    if parsed.controller.gains != ControllerConfig().gains and "controller" not in heeded:
        raise UserError("controller.gains is for the drivers controller and waypoints, and neither is among drivers")
    if parsed.planner != PlannerConfig() and "planner" not in heeded:
        raise UserError("planner.* is for move_base, waypoints and drivers with +waypoints, and none is among drivers")
    return cases


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"the folder {folder} cannot be made: {error.strerror}; folder= takes another") from error
    if not os.access(folder, os.W_OK):
        raise UserError(f"the folder {folder} cannot be written; folder= takes another")


def _read(case: Case, path: Path) -> DrivenCase:
    if not path.exists():
        raise UserError(f"{case.driver} has changed while it was driven; the same command drives it again")
    return DrivenCase.read(path)


if __name__ == "__main__":
    run(main, help_text(__doc__, CompareArguments))
