"""What programs that train groups of runs have in common: list them, train what is missing, write the table."""

import shlex
import statistics
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from asddpg.atomic_write import write_whole
from asddpg.errors import UserError
from tools.experiments.run_csv import write_csv
from tools.experiments.run_store import Results, RunStore
from tools.experiments.run_training import AT_ONCE, log_path, train
from tools.experiments.runs import Group, Run
from tools.experiments.tables import describe_provenance

VERBS = ("list", "table")
# Of each of two runs at once on two cores, with one robot and with many, until there are runs to measure it by.
STEPS_PER_SECOND, STEPS_PER_SECOND_OF_MANY = 90.0, 300.0
T = TypeVar("T")


def parse_selection(names: Sequence[str], choices: Mapping[str, T], kind: str) -> tuple[str, bool, Mapping[str, T]]:
    """Read the arguments that are no options.

    Returns:
        `list`, `table` or, to train, nothing; whether published runs count; the chosen ones, all where none is named.

    Raises:
        UserError: an argument is unknown, or two exclude each other.
    """
    for name in names:
        if name not in (*VERBS, "published", *choices):
            known = f"{', '.join(choices)}, and {', '.join(VERBS)}, published"
            raise UserError(f"there is no {kind} {name!r}; there are {known}")
    if set(VERBS) <= set(names):
        raise UserError("list or table, not both")
    chosen = {name: choice for name, choice in choices.items() if name in names}
    return next((verb for verb in VERBS if verb in names), ""), "published" in names, chosen or choices


def run_grid(verb: str, groups: Mapping[str, Group], store: RunStore, draw: Callable[[Results], str]) -> None:
    """`list` the runs, write the `table` of the finished ones or, with no verb, train what is missing and write it.

    A run that fails keeps no other from being trained; the program then ends with status 1.
    """
    missing = store.missing(groups)  # an invalid argument is found before anything is done
    if verb == "list":
        print("\n".join([*_plan(groups, store), *_published_note(groups, store)]))
        return
    failed = [] if verb == "table" else train(missing, store.folder)
    _write_tables(groups, store, draw)
    if failed:
        logs = ", ".join(str(log_path(run, store.folder)) for run in failed)
        sys.exit(f"error: {len(failed)} of {len(missing)} runs failed; see the end of {logs}")


def _write_tables(groups: Mapping[str, Group], store: RunStore, draw: Callable[[Results], str]) -> None:
    results = store.results(groups)
    missing = len(store.missing(groups))
    parts = [draw(results), describe_provenance(groups, results), *_published_note(groups, store)]
    parts += [f"{missing} runs are missing."] if missing else []
    text = "\n\n".join(part for part in parts if part)
    store.folder.mkdir(parents=True, exist_ok=True)
    table, runs = store.folder / "table.md", store.folder / "table.csv"
    write_whole(table, f"{text}\n".encode())
    write_csv(runs, groups, results)
    print(f"{text}\n\nwritten to {table} and {runs}")


def _published_note(groups: Mapping[str, Group], store: RunStore) -> list[str]:
    wanted = {group.run(seed).digest for group in groups.values() for seed in group.seeds}
    count = len(wanted & store.published.keys())
    return [f"{count} published runs stand in for runs of their options."] if store.published else []


def _guess_speed(run: Run) -> float:
    """Training steps a second."""
    return STEPS_PER_SECOND if run.config.robots == 1 else STEPS_PER_SECOND_OF_MANY


def _plan(groups: Mapping[str, Group], store: RunStore) -> list[str]:
    """Every group with the arguments of its runs, and about how long the missing ones take."""
    results, missing = store.results(groups), store.missing(groups)
    lines = []
    for name, group in groups.items():
        seeds = ", ".join(map(str, group.seeds))
        lines.append(f"{name}: {group.title}; seeds {seeds}; {len(results[name])} of {len(group.seeds)} finished")
        lines.append(f"    {shlex.join(group.options)}")
    steps = sum(run.config.total_steps for run in missing)
    own = [run for runs in results.values() for run in runs.values() if run not in store.published.values()]
    speeds = [speed for run in own if (speed := run.metrics["steps_per_second"])]
    measured = statistics.median(speeds) if speeds else None
    seconds = sum(run.config.total_steps / (measured or _guess_speed(run)) for run in missing)
    hours = seconds / min(AT_ONCE, max(len(missing), 1)) / 3600
    at = f"{AT_ONCE} at once, {f'at {measured:.0f} steps/s each as measured here' if measured else 'a guess'}"
    return [*lines, f"{len(missing)} runs of {steps} steps in all to train: about {hours:.1f} h, {at}"]
