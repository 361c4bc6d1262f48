"""The tables of a comparison, as Markdown and as CSV."""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from asddpg.atomic_write import set_aside, write_whole
from asddpg.episodes.evaluation import cell
from asddpg.episodes.intervals import Estimate
from asddpg.options.parsing import flatten
from asddpg.options.values import write_value
from tools.comparison.driven_episodes import DrivenCase
from tools.comparison.figures import DIFFERENCES, FIGURES, figures_of, paired_differences
from tools.experiments.tables import markdown

LEGEND = (
    "In brackets the 95 % interval: Wilson's of rates, Student's of means, all over the episodes. Mean time: of the "
    "episodes that reached the goal. ω is the executed turn rate; its changes are those from one step to the next "
    "within an episode, and the three columns are means over all of them: of their size, of whether it is above "
    "0.5 rad/s, and of whether ω changes its sign with more than 0.3 rad/s on either side. Milliseconds a decision: "
    "median over all steps of the CPU time of the process (time.process_time), with one torch thread."
)
PAIRED_LEGEND = (
    "The driver less {baseline}, paired by start and goal: mean of the differences of the pairs, in brackets with "
    "Student's 95 % interval; time over the pairs that both reached."
)


def write_tables(driven: Sequence[DrivenCase], baseline: str, folder: Path) -> str:
    """Write table.md, table.csv and differences.csv; returns the first. Others of before are kept as table_1.md etc."""
    rows = [(case.driver, case.task, len(case.episodes), figures_of(case)) for case in driven]
    bases = {case.task: case for case in driven if case.driver == baseline}
    others = [case for case in driven if case.driver != baseline]
    paired = [(case.driver, case.task, *paired_differences(case, bases[case.task])) for case in others]
    parts = [_markdown("episodes", FIGURES, rows), LEGEND, *_notes(driven)]
    if paired:
        parts += [_markdown("pairs", DIFFERENCES, paired), PAIRED_LEGEND.format(baseline=baseline)]
    text = "\n\n".join(parts)
    _write(folder / "table.md", f"{text}\n")
    _write(folder / "table.csv", _csv("episodes", FIGURES, rows))
    if paired:
        _write(folder / "differences.csv", _csv("pairs", DIFFERENCES, paired))
    return text


Rows = Iterable[tuple[str, str, int, Mapping[str, Estimate]]]  # driver, task, number of episodes or pairs, figures
Columns = Mapping[str, tuple[str, str]]  # titles and forms by name


def _markdown(counted: str, columns: Columns, rows: Rows) -> str:
    header = ["driver", "task", counted, *(title for title, _ in columns.values())]
    cells = [
        [driver, task, str(count), *(cell(figures[name], form) for name, (_, form) in columns.items())]
        for driver, task, count, figures in rows
    ]
    return markdown(header, cells)


def _csv(counted: str, columns: Columns, rows: Rows) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    ends = [f"{name}{end}" for name in columns for end in ("", "_low", "_high")]
    writer.writerow(["driver", "task", counted, *ends])
    for driver, task, count, figures in rows:
        writer.writerow([driver, task, count, *(value for name in columns for value in figures[name])])
    return text.getvalue()


def _notes(driven: Sequence[DrivenCase]) -> list[str]:
    """In which constants of the task the drivers of a row differ, and whether versions do."""
    sentences = []
    for task in dict.fromkeys(case.task for case in driven):
        cases = [case for case in driven if case.task == task]
        constants = [flatten(case.conditions["task"]) for case in cases]
        for name in dict.fromkeys(name for each in constants for name in each):
            drivers = _group([each.get(name) for each in constants], [case.driver for case in cases])
            if len(drivers) > 1:
                values = ", ".join(f"{value} of {' and '.join(names)}" for value, names in drivers.items())
                sentences.append(f"In {task} task.{name} differs: {values}.")
    if len({tuple(sorted(_packages(case).items())) for case in driven}) > 1:
        sentences.append("Not all were driven with the same versions; the files hold them.")
    return ["\n".join(f"- {each}" for each in sentences)] if sentences else []


def _group(values: Iterable[Any], drivers: Iterable[str]) -> dict[str, list[str]]:
    """Drivers by value."""
    groups: dict[str, list[str]] = {}
    for value, driver in zip(values, drivers, strict=True):
        groups.setdefault(write_value(value), []).append(driver)
    return groups


def _packages(case: DrivenCase) -> dict[str, str]:
    return {name: version for name, version in case.versions.items() if name != "model_hash"}


def _write(path: Path, text: str) -> None:
    content = text.encode()
    write_whole(path, content, lambda old: set_aside(old) if old.read_bytes() != content else None)
