"""The runs behind the published results: `python -m tools.results`, or some of the groups by name.

Trains what is missing in runs/results, two runs at a time, and writes the table. Finished runs are kept and not trained
again; an interrupted one goes on. `list` prints the groups and how long they take, `table` the table of the finished
runs. With `published` the runs of docs/runs/results.csv count as finished. Groups named `…_one_robot`, and the paper's,
are trained with one robot and an update after each step, the others with the defaults.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks.options import argument
from tools.experiments import controller_alone
from tools.experiments.grid import parse_selection, run_grid
from tools.experiments.one_robot import one_robot
from tools.experiments.run_csv import PUBLISHED, read_csv
from tools.experiments.run_store import Results, RunStore
from tools.experiments.runs import Group
from tools.experiments.tables import LEGEND, runs_table

FOLDER = Path("runs") / "results"
TABLE = PUBLISHED / "results.csv"
SEEDS, THREE_SEEDS = (0, 1, 2, 3, 4), (0, 1, 2)
COMPLEX = ("task=nav_complex", "reward=sparse")

DEFAULTS = {
    "empty": Group("nav_empty, dense, 30k steps", ("task=nav_empty", "reward=dense"), 30_000, SEEDS),
    "simple": Group("nav_simple, dense, 60k steps", ("task=nav_simple", "reward=dense"), 60_000, SEEDS),
    "complex": Group("nav_complex, sparse, 100k steps", COMPLEX, 100_000, SEEDS),
    "gazebo": Group("nav_gazebo, sparse, 150k steps", ("task=nav_gazebo", "reward=sparse"), 150_000, SEEDS),
}


def _with_one_robot(group: Group) -> Group:
    return replace(group, title=f"{group.title}, one robot", arguments=one_robot(group.arguments))


# What is compared with one robot; the paper's preset has one by itself.
GROUPS = {
    **DEFAULTS,
    **{f"{name}_one_robot": _with_one_robot(DEFAULTS[name]) for name in DEFAULTS},
    "complex_ddpg_one_robot": _with_one_robot(Group("nav_complex, DDPG", (*COMPLEX, "agent=ddpg"), 100_000, SEEDS)),
    "complex_paper": _with_one_robot(
        Group("nav_complex, asddpg_paper", (*COMPLEX, "agent=asddpg_paper"), 100_000, SEEDS)
    ),
    **{
        f"network_{name}_one_robot": _with_one_robot(
            Group(f"nav_complex, {name}", (*COMPLEX, f"network={name}"), 100_000, THREE_SEEDS)
        )
        for name in ("fc2x100", "fc3x100", "fc3x256")
    },
    **{
        f"gains_{p_l}_one_robot": _with_one_robot(
            Group(f"nav_complex, P({p_l}, 1)", (*COMPLEX, f"controller.gains=[{p_l},1]"), 100_000, THREE_SEEDS),
        )
        for p_l in ("0.1", "1", "10")
    },
}


@dataclass(frozen=True)
class ResultsArguments:
    """The groups to train."""

    groups: list[str] = argument("Groups, all where none is named; list or table; published.", [])


def main(arguments: Sequence[str]) -> None:
    """Train and write the table, or list."""
    verb, is_published, groups = parse_selection(parse_arguments(ResultsArguments, arguments).groups, GROUPS, "group")
    store = RunStore(FOLDER, read_csv(TABLE) if is_published else {})
    run_grid(verb, groups, store, lambda results: draw(groups, results, may_drive=not verb))


def draw(groups: Mapping[str, Group], results: Results, may_drive: bool) -> str:
    """The runs, and what the controller does alone in their rooms and with their gains."""
    assisted = [group.config for group in groups.values() if group.config.agent.assisted]
    alone = controller_alone.table(assisted, FOLDER, may_drive)
    if assisted and not alone:
        alone = "The controller alone has not been driven here yet; without `table` it is."
    return "\n\n".join(part for part in (runs_table(groups, results), LEGEND, alone) if part)


if __name__ == "__main__":
    run(main, f"{help_text(__doc__, ResultsArguments)}\n\nGroups: {', '.join(GROUPS)}")
