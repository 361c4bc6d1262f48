"""What programs that train groups of runs have in common: list them, train what is missing, write the table."""

import shlex
import statistics
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from tools.experiments.run_csv import PublishedRun, outdated, published_runs, write_csv
from tools.experiments.run_groups import Group, finished, missing
from tools.experiments.run_metrics import read_run_metrics
from tools.experiments.run_provenance import provenance
from tools.experiments.run_store import StoredRun, stored_runs
from tools.experiments.run_tables import Result, Results
from tools.experiments.run_training import AT_ONCE, log_of, train

VERBS = ("list", "table")
OWN_WORDS = (*VERBS, "published")
STEPS_PER_SECOND = 90.0  # of each of two runs at once on two cores, until there are runs to measure it by
Known = Sequence[StoredRun | PublishedRun]


def known_runs(groups: Mapping[str, Group], folder: Path, published: Path | None = None) -> Known:
    """The finished runs of a folder; after them those of a published file.

    Raises:
        UserError: there is no such file, or it is damaged.
    """
    return [*stored_runs(folder), *(published_runs(published, groups) if published else [])]


def run_grid(
    verb: str,
    groups: Mapping[str, Group],
    folder: Path,
    report: Callable[[Results], str],
    published: Path | None = None,
) -> str:
    """Do what was asked: `list` the runs, write the `table` of those there are, or, with no verb, train and write it.

    Runs of the published file, if one is given, count as there. A run that fails keeps none of the others from being
    trained; which did is said in what comes back, nothing where none did.
    """
    known = known_runs(groups, folder, published)
    todo = missing(groups, known)  # a wrong word is found before anything is done
    if verb != "table":
        begin = f"{len(todo)} runs to train, {AT_ONCE} at a time; each one's output goes into {folder}/<run>.log"
        said = plan(groups, known) if verb == "list" else begin
        print("\n".join(part for part in (said, _published_sentence(groups, published)) if part), flush=True)
    if verb == "list":
        return ""
    failed = [] if verb == "table" else train(todo, folder)
    write_tables(groups, folder, report, published)
    logs = ", ".join(str(log_of(run, folder)) for run in failed)
    return f"{len(failed)} of {len(todo)} runs failed; their last words are in {logs}" if failed else ""


def end(failed: str) -> None:
    """End a program with status 1 where runs failed."""
    if failed:
        sys.exit(f"error: {failed}")


def write_tables(
    groups: Mapping[str, Group], folder: Path, report: Callable[[Results], str], published: Path | None = None
) -> None:
    """Write table.md and table.csv of the runs there are, and print the first."""
    known = known_runs(groups, folder, published)
    results = results_of(groups, known)
    said = _published_sentence(groups, published), _missing_sentence(groups, known)
    parts = [report(results), provenance(results), *said]
    text = "\n\n".join(part for part in parts if part)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "table.md").write_text(text + "\n", encoding="utf-8")
    write_csv(folder / "table.csv", groups, results)
    print(f"{text}\n\nwritten to {folder / 'table.md'} and {folder / 'table.csv'}")


def results_of(groups: Mapping[str, Group], known: Known) -> Results:
    """The finished runs of each group with their figures."""
    return {name: [_result(run) for run in runs] for name, runs in finished(groups, known).items()}


def _result(run: StoredRun | PublishedRun) -> Result:
    return Result(run, run.metrics if isinstance(run, PublishedRun) else read_run_metrics(run))


def _published_sentence(groups: Mapping[str, Group], published: Path | None) -> str:
    if published is None:
        return ""
    said = f"{len(published_runs(published, groups))} published runs stand in for runs of their options."
    number = outdated(published)
    return f"{said} {number} serve nobody: today their words mean other options." if number else said


def _missing_sentence(groups: Mapping[str, Group], known: Known) -> str:
    todo = missing(groups, known)
    return f"{len(todo)} runs are missing." if todo else ""


def plan(groups: Mapping[str, Group], known: Known) -> str:
    """Every group with the words of its runs, and about how long the missing ones take."""
    there = finished(groups, known)
    lines = []
    for name, group in groups.items():
        seeds = ", ".join(str(seed) for seed in group.seeds)
        lines.append(f"{name}: {group.title}; seeds {seeds}; {len(there[name])} of {len(group.seeds)} finished")
        lines.append(f"    {shlex.join(group.options)}")
    todo = missing(groups, known)
    steps = sum(int(run.settings["total_steps"]) for run in todo)
    speed, source = _speed([run for run in known if isinstance(run, StoredRun)])
    hours = steps / speed / min(AT_ONCE, max(len(todo), 1)) / 3600
    at = f"{AT_ONCE} at once at {speed:.0f} steps/s each, {source}"
    return "\n".join([*lines, f"{len(todo)} runs of {steps} steps in all to train: about {hours:.1f} h, {at}"])


def _speed(stored: Sequence[StoredRun]) -> tuple[float, str]:
    speeds = [speed for run in stored if (speed := read_run_metrics(run).steps_per_second)]
    return (statistics.median(speeds), "as measured here") if speeds else (STEPS_PER_SECOND, "a guess")
