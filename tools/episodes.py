"""What recordings there are: `python -m tools.episodes DIR`.

Lists those in a folder and below it, such as runs/mine or runs. Options choose among them, or export their steps:

  outcome=crashed    or several: crashed,timeout; running are those of killed processes (tools.recover)
  task=nav_complex   of one task
  min_steps=50       of so many steps or more
  export=steps.csv   /step of all of them as one table, a row a step; .parquet too; --export csv is export=steps.csv
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tasks
from asddpg.episodes.protocols import Driver
from asddpg.errors import UserError
from asddpg.program import run
from asddpg.recording.files.reading import Recording, open_recording
from asddpg.recording.files.recording_file import PART
from asddpg.recording.messages.step_message import read_reward
from asddpg.recording.messages.topics import OUTCOME, STEP
from tools.option_arguments import options_in
from tools.recordings.step_table import SUFFIXES, Row, check_can_write, row_of, write_table

OPTIONS = ("outcome", "task", "min_steps", "export")
OUTCOMES = ("reached", "crashed", "timeout", "cut", "running")
HEADER = ("file", "task", "outcome", "steps", "return", "controller", "start (m, m, rad)", "goal (m)", "kB", "trained")
KILOBYTE = 1000


@dataclass(frozen=True)
class Wish:
    """Which recordings are asked for."""

    folder: Path
    outcomes: Sequence[str] = ()  # none given, all
    task: str | None = None
    min_steps: int = 0
    export: Path | None = None


@dataclass(frozen=True)
class Listed:
    """A recording in figures."""

    recording: Recording
    outcome: str
    steps: Sequence[dict[str, Any]]
    total_reward: float
    controller_share: float
    size: int  # bytes


def wish(arguments: Sequence[str]) -> Wish:
    """Read the command line's words; UserError where one is wrong."""
    arguments = list(_without_dashes(arguments))
    plain = [
        argument
        for argument in arguments
        if argument.partition("=")[0] not in OPTIONS and ("=" not in argument or Path(argument).exists())
    ]
    if len(plain) != 1:
        raise UserError("list which recordings? python -m tools.episodes <folder> [outcome=crashed] [export=steps.csv]")
    options = options_in((argument for argument in arguments if argument not in plain), OPTIONS)
    outcomes = [each for each in options.get("outcome", "").split(",") if each]
    unknown = [each for each in outcomes if each not in OUTCOMES]
    if unknown or ("outcome" in options and not outcomes):
        raise UserError(f"there is no outcome {options['outcome']!r}; there are {', '.join(OUTCOMES)}")
    task = options.get("task")
    if task is not None and task not in tasks.ALL_TASKS:
        raise UserError(f"there is no task {task!r}; there are {', '.join(tasks.ALL_TASKS)}")
    export = Path(options["export"]) if "export" in options else None
    return Wish(Path(plain[0]), outcomes, task, _number(options.get("min_steps", "0")), export)


def _without_dashes(arguments: Sequence[str]) -> Iterator[str]:
    """`--export csv` as the option it stands for."""
    rest = iter(arguments)
    for argument in rest:
        if argument != "--export":
            yield argument
            continue
        kind = next(rest, "")
        if f".{kind}" not in SUFFIXES:
            raise UserError(f"--export takes csv or parquet, not {kind!r}")
        yield f"export=steps.{kind}"


def _number(value: str) -> int:
    if not (value.isascii() and value.isdigit() and len(value) < 10):
        raise UserError(f"min_steps must be a whole number, 0 or more, not {value!r}")
    return int(value)


def recordings_below(folder: Path) -> list[Path]:
    """Recordings, those cut off among them, in the order of folder and time.

    Raises:
        UserError: there are none.
    """
    if not folder.is_dir():
        raise UserError(f"there is no folder {folder}; recordings lie in a run's folder, in episodes/")
    found = sorted(path for ending in ("mcap", f"mcap{PART}") for path in folder.rglob(f"*.{ending}") if path.is_file())
    if not found:
        raise UserError(f"there are no recordings (*.mcap) in {folder} or below it; record.every= makes some")
    return found


def listed(path: Path) -> Listed:
    """A recording in figures; those of one that was cut off are counted here.

    Raises:
        UserError: it is damaged, or of another program.
    """
    recording = open_recording(path)
    steps: list[dict[str, Any]] = []
    outcome: dict[str, Any] = {"outcome": "running"}
    for message in recording.messages(STEP, OUTCOME):
        if message.topic == STEP:
            steps.append(message.content)
        else:
            outcome = message.content
    try:
        share = sum(step["driver"] == Driver.CONTROLLER for step in steps) / max(len(steps), 1)
        total = sum(map(read_reward, steps))
        return Listed(recording, outcome["outcome"], steps, total, share, path.stat().st_size)
    except (KeyError, TypeError) as error:
        raise UserError(f"{path} was made by another version: its /step or /outcome lacks {error}") from error


def is_wanted(found: Listed, asked: Wish) -> bool:
    """Whether a recording is among those asked for."""
    return (
        (not asked.outcomes or found.outcome in asked.outcomes)
        and asked.task in (None, found.recording.facts.get("task"))
        and len(found.steps) >= asked.min_steps
    )


def cells(found: Listed, folder: Path) -> tuple[str, ...]:
    """A line of the table."""
    recording = found.recording
    return (
        str(recording.path.relative_to(folder)),
        recording.facts.get("task", "–"),
        found.outcome,
        str(len(found.steps)),
        f"{found.total_reward:.2f}",
        f"{found.controller_share:.2f}",
        ", ".join(f"{number:.2f}" for number in recording.start),
        ", ".join(f"{number:.2f}" for number in recording.goal),
        f"{found.size / KILOBYTE:.0f}",
        recording.facts.get("step", "–"),
    )


def aligned(lines: Sequence[Sequence[str]]) -> str:
    """Cells in columns, names to the left, figures to the right."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    names = ("file", "task", "outcome")
    return "\n".join(
        "  ".join(
            cell.ljust(width) if title in names else cell.rjust(width)
            for cell, width, title in zip(line, widths, HEADER, strict=True)
        ).rstrip()
        for line in lines
    )


def main(arguments: Sequence[str]) -> None:
    """List, sum up, export."""
    asked = wish(arguments)
    if asked.export is not None:
        check_can_write(asked.export)
    lines: list[Sequence[str]] = [HEADER]
    rows: list[Row] = []
    damaged: list[str] = []
    counts: Counter[str] = Counter()
    size = 0
    for path in recordings_below(asked.folder):
        try:
            found = listed(path)
            if not is_wanted(found, asked):
                continue
            lines.append(cells(found, asked.folder))
        except UserError as error:
            damaged.append(str(error))
            continue
        counts[found.outcome] += 1
        size += found.size
        if asked.export is not None:
            rows += (row_of(lines[-1][0], step) for step in found.steps)
    if counts:
        print(aligned(lines))
    print(_summary(counts, size))
    for sentence in damaged:
        print(f"damaged: {sentence}")
    if asked.export is not None:
        _export(asked.export, rows)


def _summary(counts: Counter[str], size: int) -> str:
    if not counts:
        return "no recording is as asked for"
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    total = counts.total()
    return f"{total} recording{'s' * (total > 1)}, {size / KILOBYTE**2:.1f} MB: {outcomes}"


def _export(path: Path, rows: Sequence[Row]) -> None:
    if not rows:
        raise UserError(f"there is no step to export, so {path} is not written")
    write_table(path, rows)
    print(f"{len(rows)} steps written to {path}")


if __name__ == "__main__":
    run(main, str(__doc__))
