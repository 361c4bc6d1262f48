"""The ablation: `python -m tools.ablation [factor…] seeds=100,101,102 steps=60000 task=nav_complex`.

One factor taken away from the default at a time, or added where the default does without; and each added alone to the
paper's setting, agent=asddpg_paper. tools/experiments/factors.py holds the factors. All groups are trained with one
robot and an update after each step, and with the defaults of the time when they were measured; `robots=16` trains them
with so many and today's. Trains what is missing in runs/ablation, two runs at a time, and writes the table;
once interrupted, it goes on where it was. The first seed goes first: a setting that then has a success rate 0.1 below
the one it is measured against, or below 0.1 at all, is ruled out and not trained on the others. `list` prints the runs
and how long they take at most, `table` the table of the finished ones. With `published` the runs of
docs/runs/ablation.csv count as finished, so that only what is new is trained. Other options of `python -m asddpg.train`
go to every run.
"""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from asddpg.errors import UserError
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks.options import POSITIVE, SHARE, Range, argument, option
from tools.experiments.ablation_table import ablation_table, screen
from tools.experiments.factors import FACTORS, Factor
from tools.experiments.grid import parse_selection, run_grid
from tools.experiments.one_robot import one_robot
from tools.experiments.run_csv import PUBLISHED, read_csv
from tools.experiments.run_store import RunStore
from tools.experiments.run_training import train
from tools.experiments.runs import Group

FOLDER = Path("runs") / "ablation"
TABLE = PUBLISHED / "ablation.csv"
ROOTS = {"default": "agent=asddpg", "paper": "agent=asddpg_paper"}
SET_BY_GRID = ("run_dir", "seed", "total_steps", "agent")
SEEDS = Range(
    lambda seeds: len(set(seeds)) == len(seeds) > 0 <= min(seeds), "one or more seeds, different and 0 or more"
)


@dataclass(frozen=True)
class AblationArguments:
    """The settings to train and to compare."""

    factors: list[str] = argument("Factors, all where none is named; list or table; published.", [])
    seeds: list[int] = option([100, 101, 102], "Seeds of each setting.", SEEDS)
    paper_seeds: list[int] | None = option(None, "Seeds of the paper's settings; null takes seeds.", SEEDS)
    steps: int = option(60_000, "Training steps of each run.", POSITIVE)
    rule_out: float | None = option(0.1, "Success rate by which the first seed rules out; null trains all.", SHARE)


def parse(arguments: Sequence[str]) -> tuple[AblationArguments, tuple[str, ...]]:
    """The arguments of the ablation, and those that go to every run; UserError where one is invalid."""
    own = [each for each in arguments if "=" not in each or each.partition("=")[0] in vars(AblationArguments())]
    others = [each for each in arguments if each not in own]
    names = [each.partition("=")[0] for each in others]
    for name in names:
        if name in SET_BY_GRID:
            raise UserError(f"the grid sets {name} itself; you may set seeds=, paper_seeds=, steps= and task=")
    task = () if "task" in names else ("task=nav_complex",)
    return parse_arguments(AblationArguments, own), (*task, *others)


def make_grid(parsed: AblationArguments, others: Sequence[str]) -> dict[str, Group]:
    """The two roots, and below each the groups that differ from it, or from another group, by one factor.

    `others` are arguments of every run.
    """
    _, _, factors = parse_selection(parsed.factors, FACTORS, "factor")

    def make_group(root: str, title: str, reference: str | None, change: str = "") -> Group:
        seeds = (parsed.paper_seeds if root == "paper" else None) or parsed.seeds
        arguments = (*others, ROOTS[root], *change.split())
        return Group(
            title, arguments if _sets_robots(others) else one_robot(arguments), parsed.steps, tuple(seeds), reference
        )

    grid: dict[str, Group] = {}
    for root in ROOTS:
        grid[root] = make_group(root, root, None)
        for name, factor in factors.items():
            beside = make_group(root, f"{root} for {name}", root, factor.beside)
            reference = next((known for known, group in grid.items() if group.digest == beside.digest), None)
            if reference is None:
                reference = beside.title.replace(" ", "_")
                grid[reference] = beside
            changes = {"without": factor.off, "with": factor.on} if root == "default" else {"with": factor.on}
            for preposition, change in changes.items():
                title = f"{root} {preposition} {name}"
                changed = make_group(root, title, reference, f"{factor.beside} {change}")
                if changed.digest != grid[reference].digest:
                    grid[title.replace(" ", "_")] = changed
    return grid


def main(arguments: Sequence[str]) -> None:
    """Train and draw the table, or list."""
    parsed, others = parse(arguments)
    verb, is_published, factors = parse_selection(parsed.factors, FACTORS, "factor")
    store = RunStore(FOLDER, read_csv(TABLE) if is_published else {})
    grid = make_grid(parsed, others)
    if parsed.rule_out is not None:
        first = {name: replace(group, seeds=group.seeds[:1]) for name, group in grid.items()}
        if not verb and first != grid:
            train(store.missing(first), FOLDER)  # a run that fails here is tried again below
        grid = screen(grid, store.results(grid), parsed.rule_out)
    shape = "" if _sets_robots(others) else ", one robot, an update after each step"
    title, legend = f"{shlex.join(others)}, {parsed.steps} steps{shape}", _describe_factors(factors)
    run_grid(verb, grid, store, lambda results: f"{ablation_table(title, grid, results)}\n\n{legend}")


def _sets_robots(arguments: Sequence[str]) -> bool:
    return any(argument.startswith("robots=") for argument in arguments)


def _describe_factors(factors: Mapping[str, Factor]) -> str:
    return "\n".join(f"- `{name}`: {factor.title} ({factor.source})" for name, factor in factors.items())


if __name__ == "__main__":
    run(main, f"{help_text(__doc__, AblationArguments)}\n\nFactors:\n{_describe_factors(FACTORS)}")
