"""The ablation: `python -m tools.ablation [factor…] seeds=100,101,102 steps=60000 task=nav_complex`.

One factor taken away from the default at a time, or added where the default does without; and each added alone to the
paper's setting, agent=asddpg_paper, for which paper_seeds=100 takes fewer seeds. tools/experiments/factors.py holds the
factors. Trains what is missing in runs/ablation, two runs at a time, and writes the table; once interrupted, it goes on
where it was. The first seed goes first: a setting that then has a success rate 0.1 below the one it is measured
against, or below 0.1 at all, is ruled out and not trained on the others (`rule_out=0.2` for another margin,
`rule_out=none` to train all). `list` prints the runs and how long they take at most, `table` the table of the finished
ones. With `published` the runs of docs/runs/ablation.csv count as finished, so that only what is new is trained. Other
options of `python -m asddpg.train` go to every run.
"""

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from asddpg.errors import UserError
from asddpg.program import run
from tools.experiments.ablation_table import ablation_table, screen
from tools.experiments.factors import FACTORS, Factor
from tools.experiments.grid import parse_choices, run_grid
from tools.experiments.run_csv import PUBLISHED, read_csv
from tools.experiments.run_store import RunStore
from tools.experiments.run_training import train
from tools.experiments.runs import Group
from tools.option_arguments import options_in

FOLDER = Path("runs") / "ablation"
TABLE = PUBLISHED / "ablation.csv"
ROOTS = {"default": "agent=asddpg", "paper": "agent=asddpg_paper"}
SET_BY_GRID = ("run_dir", "seed", "total_steps", "agent")


@dataclass(frozen=True)
class Options:
    """What the command line sets; `arguments` go to every run."""

    verb: str
    is_published: bool
    factors: Mapping[str, Factor]
    seeds: tuple[int, ...]
    paper_seeds: tuple[int, ...]
    steps: int
    margin: float | None
    arguments: tuple[str, ...]


def parse(arguments: Sequence[str]) -> Options:
    """Read a command line; UserError where it is invalid."""
    names = [argument for argument in arguments if "=" not in argument]
    verb, is_published, factors = parse_choices(names, FACTORS, "factor")
    options = {"task": "nav_complex"} | options_in(argument for argument in arguments if "=" in argument)
    fixed = [name for name in options if name in SET_BY_GRID]
    if fixed:
        raise UserError(f"the grid sets {fixed[0]} itself; you may set seeds=, paper_seeds=, steps= and task=")
    all_seeds = options.pop("seeds", "100,101,102")
    seeds = _parse_integers("seeds", all_seeds)
    paper_seeds = _parse_integers("paper_seeds", options.pop("paper_seeds", all_seeds))
    steps = _parse_integers("steps", options.pop("steps", "60000"))
    if len(steps) > 1:
        raise UserError(f"steps must be one whole number, not {len(steps)}")
    margin = _parse_margin(options.pop("rule_out", "0.1"))
    others = tuple(f"{name}={value}" for name, value in options.items())
    return Options(verb, is_published, factors, seeds, paper_seeds, steps[0], margin, others)


def _parse_integers(name: str, text: str) -> tuple[int, ...]:
    if not re.fullmatch(r"\d+(,\d+)*", text):
        raise UserError(f"{name} must be whole numbers such as {name}=100,101, not {text!r}")
    return tuple(dict.fromkeys(int(number) for number in text.split(",")))


def _parse_margin(text: str) -> float | None:
    if text == "none":
        return None
    if not re.fullmatch(r"0?\.\d+|[01](\.0*)?", text):
        raise UserError(f"rule_out must be a share of episodes such as rule_out=0.1, or none, not {text!r}")
    return float(text)


def make_grid(options: Options) -> dict[str, Group]:
    """The two roots, and below each the groups that differ from it, or from another group, by one factor."""
    grid: dict[str, Group] = {}
    for root in ROOTS:
        grid[root] = _group(options, root, root, None)
        for name, factor in options.factors.items():
            beside = _group(options, root, f"{root} for {name}", root, factor.beside)
            reference = next((known for known, group in grid.items() if group.digest == beside.digest), None)
            if reference is None:
                reference = beside.title.replace(" ", "_")
                grid[reference] = beside
            changes = {"without": factor.off, "with": factor.on} if root == "default" else {"with": factor.on}
            for preposition, change in changes.items():
                title = f"{root} {preposition} {name}"
                changed = _group(options, root, title, reference, f"{factor.beside} {change}")
                if changed.digest != grid[reference].digest:
                    grid[title.replace(" ", "_")] = changed
    return grid


def _group(options: Options, root: str, title: str, reference: str | None, change: str = "") -> Group:
    seeds = options.paper_seeds if root == "paper" else options.seeds
    return Group(title, (*options.arguments, ROOTS[root], *change.split()), options.steps, seeds, reference)


def main(arguments: Sequence[str]) -> None:
    """Train and draw the table, or list."""
    options = parse(arguments)
    store = RunStore(FOLDER, read_csv(TABLE) if options.is_published else {})
    grid = make_grid(options)
    if options.margin is not None:
        first = {name: replace(group, seeds=group.seeds[:1]) for name, group in grid.items()}
        if not options.verb and first != grid:
            train(store.missing(first), FOLDER)  # a run that fails here is tried again below
        grid = screen(grid, store.results(grid), options.margin)
    title, legend = f"{shlex.join(options.arguments)}, {options.steps} steps", _describe_factors(options.factors)
    run_grid(options.verb, grid, store, lambda results: f"{ablation_table(title, grid, results)}\n\n{legend}")


def _describe_factors(factors: Mapping[str, Factor]) -> str:
    return "\n".join(f"- `{name}`: {factor.title} ({factor.source})" for name, factor in factors.items())


if __name__ == "__main__":
    run(main, f"{__doc__}\nFactors:\n{_describe_factors(FACTORS)}")
