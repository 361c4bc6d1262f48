"""The ablation: `python -m tools.ablation [factor…] seeds=100,101,102 steps=60000 task=nav_complex`.

One factor taken away from the default at a time, or added where the default does without; and each added alone to the
paper's setting, agent=asddpg_paper, for which paper_seeds=100 takes fewer seeds. tools/experiments/factors.py holds the
factors. Trains what is missing in runs/ablation, two runs at a time, and writes the table; broken off, it goes on where
it was. The first seed goes first: a setting that then reaches 0.1 less than what it is measured against, or less than
0.1 at all, is ruled out and not trained on the others (`rule_out=0.2` for another margin, `rule_out=none` to train
all). `list` prints the runs and how long they take at most, `table` the table of those there are. With `published` the
runs of docs/runs/ablation.csv count as there, so that only what is new is trained. Other words of
`python -m asddpg.train` go to every run.
"""

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from asddpg.errors import UserError
from asddpg.program import run
from tools.experiments.ablation_table import Row, report
from tools.experiments.factors import FACTORS, Factor
from tools.experiments.run_csv import PUBLISHED
from tools.experiments.run_grid import OWN_WORDS, VERBS, end, known_runs, results_of, run_grid
from tools.experiments.run_groups import Group
from tools.experiments.run_tables import Results
from tools.experiments.screening import first_round, screened
from tools.option_arguments import options_in

FOLDER = Path("runs") / "ablation"
TABLE = PUBLISHED / "ablation.csv"
ROOTS = {"default": "agent=asddpg", "paper": "agent=asddpg_paper"}
GIVEN = ("run_dir", "seed", "total_steps", "agent")  # options that the grid itself sets


@dataclass(frozen=True)
class Request:
    """What a command line asks for."""

    verb: str
    factors: Mapping[str, Factor]
    seeds: tuple[int, ...]
    paper_seeds: tuple[int, ...]
    steps: int
    margin: float | None
    published: Path | None
    arguments: tuple[str, ...]


def request(arguments: Sequence[str]) -> Request:
    """Read a command line.

    Raises:
        UserError: a word means nothing here.
    """
    options = options_in(argument for argument in arguments if "=" in argument)
    plain = [argument.removeprefix("--") for argument in arguments if "=" not in argument]
    unknown = [argument for argument in plain if argument not in (*OWN_WORDS, *FACTORS)]
    if unknown:
        raise UserError(
            f"there is no factor {unknown[0]!r}; there are {', '.join(FACTORS)}, and {', '.join(OWN_WORDS)}"
        )
    taken = [name for name in options if name in GIVEN]
    if taken:
        raise UserError(f"{taken[0]} is what the grid sets itself; seeds=, paper_seeds=, steps= and task= are yours")
    verbs = [argument for argument in plain if argument in VERBS]
    if len(verbs) > 1:
        raise UserError("list or table, not both")
    all_seeds = options.pop("seeds", "100,101,102")
    seeds = _whole_numbers("seeds", all_seeds)
    paper_seeds = _whole_numbers("paper_seeds", options.pop("paper_seeds", all_seeds))
    steps = _whole_numbers("steps", options.pop("steps", "60000"))
    if len(steps) > 1:
        raise UserError(f"steps must be one whole number, not {len(steps)}")
    margin = _margin(options.pop("rule_out", "0.1"))
    chosen = {name: factor for name, factor in FACTORS.items() if name in plain}
    rest = {"task": "nav_complex"} | options
    shared = tuple(f"{name}={value}" for name, value in rest.items())
    published = TABLE if "published" in plain else None
    return Request("".join(verbs), chosen or FACTORS, seeds, paper_seeds, steps[0], margin, published, shared)


def _whole_numbers(name: str, text: str) -> tuple[int, ...]:
    if not re.fullmatch(r"\d+(,\d+)*", text):
        raise UserError(f"{name} must be whole numbers such as {name}=100,101, not {text!r}")
    return tuple(dict.fromkeys(int(number) for number in text.split(",")))


def _margin(text: str) -> float | None:
    if text == "none":
        return None
    if not re.fullmatch(r"0?\.\d+|[01](\.0*)?", text):
        raise UserError(f"rule_out must be a share of episodes such as rule_out=0.1, or none, not {text!r}")
    return float(text)


def rows(asked: Request) -> dict[str, Row]:
    """The grid: the two roots, and below each what differs from it, or from another row, by one factor."""
    found: dict[str, Row] = {}
    for root, agent in ROOTS.items():
        found[root] = Row(_group(asked, root, root, agent), None)
        for name, factor in asked.factors.items():
            reference = _reference(asked, found, root, name)
            changes = {"without": factor.off, "with": factor.on} if root == "default" else {"with": factor.on}
            for preposition, arguments in changes.items():
                title = f"{root} {preposition} {name}"
                changed = _group(asked, root, title, agent, *factor.beside, *arguments)
                if changed.settings(0) != found[reference].group.settings(0):
                    found[title.replace(" ", "_")] = Row(changed, reference)
    return found


def _reference(asked: Request, found: dict[str, Row], root: str, name: str) -> str:
    """The row that a factor's rows are measured against; it is added where none of the grid has what goes beside."""
    beside = _group(asked, root, f"{root} for {name}", ROOTS[root], *asked.factors[name].beside)
    for known, row in found.items():
        if row.group.settings(0) == beside.settings(0):
            return known
    added = beside.title.replace(" ", "_")
    found[added] = Row(beside, root)
    return added


def _group(asked: Request, root: str, title: str, *arguments: str) -> Group:
    seeds = asked.paper_seeds if root == "paper" else asked.seeds
    return Group(title, (*asked.arguments, *arguments), asked.steps, seeds)


def main(arguments: Sequence[str]) -> None:
    """Train and draw the table, or list."""
    asked = request(arguments)
    grid = rows(asked)
    if asked.margin is not None:
        if not asked.verb and any(len(row.group.seeds) > 1 for row in grid.values()):
            _run(asked, grid, first_round(grid))  # what fails here is tried again below, and told there
        groups = _groups(grid)
        grid = screened(grid, results_of(groups, known_runs(groups, FOLDER, asked.published)), asked.margin)
    end(_run(asked, grid, _groups(grid)))


def _run(asked: Request, grid: Mapping[str, Row], groups: Mapping[str, Group]) -> str:
    title, legend = f"{shlex.join(asked.arguments)}, {asked.steps} steps", _legend(asked.factors)

    def drawn(results: Results) -> str:
        return f"{report(title, grid, results)}\n\n{legend}"

    return run_grid(asked.verb, groups, FOLDER, drawn, asked.published)


def _groups(grid: Mapping[str, Row]) -> dict[str, Group]:
    return {name: row.group for name, row in grid.items()}


def _legend(factors: Mapping[str, Factor]) -> str:
    return "\n".join(f"- `{name}`: {factor.title} ({factor.source})" for name, factor in factors.items())


def usage() -> str:
    """What --help prints."""
    return f"{__doc__}\nFactors:\n{_legend(FACTORS)}"


if __name__ == "__main__":
    run(main, usage())
