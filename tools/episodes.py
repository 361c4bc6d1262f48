"""List recordings: `python -m tools.episodes runs/mine`.

Lists those in a folder and below it, such as runs/mine or runs. Options choose among them, or export their steps.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asddpg.episodes.protocols import Driver
from asddpg.errors import UserError
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.recording.files.reading import Recording, open_recording
from asddpg.recording.files.recording_file import PART
from asddpg.recording.messages.step_message import read_reward
from asddpg.recording.messages.topics import OUTCOME, STEP
from tasks import ALL_TASKS
from tasks.options import NOT_NEGATIVE, argument, one_of, option, some_of
from tools.recordings.step_table import Row, check_can_write, row_of, write_table

OUTCOMES = ("reached", "crashed", "timeout", "cut", "running")
HEADER = ("file", "task", "outcome", "steps", "return", "controller", "start (m, m, rad)", "goal (m)", "kB", "trained")
KILOBYTE = 1000


@dataclass(frozen=True)
class EpisodesArguments:
    """Which recordings are listed, and what is exported of them."""

    folder: Path = argument("Folder of recordings, such as runs/mine or runs.")
    outcome: list[str] = option(
        [],
        "Outcomes, such as crashed,timeout; running are recordings of killed processes (tools.recover); [] lists all.",
        some_of(*OUTCOMES),
    )
    task: str | None = option(None, "Of one task; null lists all.", one_of(*ALL_TASKS))
    min_steps: int = option(0, "Of so many steps or more.", NOT_NEGATIVE)
    export: Path | None = option(None, "/step of all of them as one table, a row a step, .csv or .parquet.")


@dataclass(frozen=True)
class Listed:
    """A recording and its metrics."""

    recording: Recording
    outcome: str
    steps: Sequence[dict[str, Any]]
    total_reward: float
    controller_share: float
    size: int  # bytes


def recordings_below(folder: Path) -> list[Path]:
    """Recordings, with interrupted ones, in the order of folder and time.

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
    """A recording and its metrics; those of an interrupted one are computed here.

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


def is_selected(found: Listed, parsed: EpisodesArguments) -> bool:
    """Whether a recording is to be listed."""
    return (
        (not parsed.outcome or found.outcome in parsed.outcome)
        and parsed.task in (None, found.recording.facts.get("task"))
        and len(found.steps) >= parsed.min_steps
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
    """Cells in columns, names to the left, numbers to the right."""
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
    parsed = parse_arguments(EpisodesArguments, arguments)
    if parsed.export is not None:
        check_can_write(parsed.export)
    lines: list[Sequence[str]] = [HEADER]
    rows: list[Row] = []
    damaged: list[str] = []
    counts: Counter[str] = Counter()
    size = 0
    for path in recordings_below(parsed.folder):
        try:
            found = listed(path)
            if not is_selected(found, parsed):
                continue
            lines.append(cells(found, parsed.folder))
        except UserError as error:
            damaged.append(str(error))
            continue
        counts[found.outcome] += 1
        size += found.size
        if parsed.export is not None:
            rows += (row_of(lines[-1][0], step) for step in found.steps)
    if rows and parsed.export is not None:
        write_table(parsed.export, rows)
    if counts:
        print(aligned(lines))
    print(_summary(counts, size))
    for sentence in damaged:
        print(f"damaged: {sentence}")
    if parsed.export is not None:
        if not rows:
            raise UserError(f"there is no step to export, so {parsed.export} is not written")
        print(f"{len(rows)} steps written to {parsed.export}")


def _summary(counts: Counter[str], size: int) -> str:
    if not counts:
        return "no recording matches"
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    total = counts.total()
    return f"{total} recording{'s' * (total > 1)}, {size / KILOBYTE**2:.1f} MB: {outcomes}"


if __name__ == "__main__":
    run(main, help_text(__doc__, EpisodesArguments))
