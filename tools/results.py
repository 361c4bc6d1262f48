"""The runs behind the README's figures: `python -m tools.results`, or some of the groups by name.

Trains what is missing in runs/results, two runs at a time, and writes the table. Finished runs are kept and not trained
again; one that was broken off goes on. `list` prints the groups and how long they take, `table` the table of the
runs there are. With `published` the runs of docs/runs/results.csv count as there.
"""

from collections.abc import Sequence
from pathlib import Path

from asddpg.command_line import train_config
from asddpg.errors import UserError
from asddpg.program import run
from tools.experiments import controller_alone
from tools.experiments.run_csv import PUBLISHED
from tools.experiments.run_grid import OWN_WORDS, VERBS, end, run_grid
from tools.experiments.run_groups import Group
from tools.experiments.run_tables import LEGEND, Results, runs_table

FOLDER = Path("runs") / "results"
TABLE = PUBLISHED / "results.csv"
SEEDS, THREE_SEEDS = (0, 1, 2, 3, 4), (0, 1, 2)
COMPLEX = ("task=nav_complex", "reward=sparse")

GROUPS = {
    "empty": Group("nav_empty, dense, 30k steps", ("task=nav_empty", "reward=dense"), 30_000, SEEDS),
    "simple": Group("nav_simple, dense, 60k steps", ("task=nav_simple", "reward=dense"), 60_000, SEEDS),
    "complex": Group("nav_complex, sparse, 100k steps", COMPLEX, 100_000, SEEDS),
    "gazebo": Group("nav_gazebo, sparse, 150k steps", ("task=nav_gazebo", "reward=sparse"), 150_000, SEEDS),
    "complex_ddpg": Group("nav_complex, DDPG", (*COMPLEX, "agent=ddpg"), 100_000, SEEDS),
    "complex_paper": Group("nav_complex, asddpg_paper", (*COMPLEX, "agent=asddpg_paper"), 100_000, SEEDS),
    **{
        f"network_{name}": Group(f"nav_complex, {name}", (*COMPLEX, f"network={name}"), 100_000, THREE_SEEDS)
        for name in ("fc2x100", "fc3x100", "fc3x256")
    },
    **{
        f"gains_{p_l}": Group(
            f"nav_complex, P({p_l}, 1)", (*COMPLEX, f"controller.gains=[{p_l},1]"), 100_000, THREE_SEEDS
        )
        for p_l in ("0.1", "1", "10")
    },
}


def main(arguments: Sequence[str]) -> None:
    """Train and write the table, or list."""
    plain = [argument.removeprefix("--") for argument in arguments]
    unknown = [argument for argument in plain if argument not in (*OWN_WORDS, *GROUPS)]
    if unknown:
        raise UserError(f"there is no group {unknown[0]!r}; there are {', '.join(GROUPS)}, and {', '.join(OWN_WORDS)}")
    verbs = [argument for argument in plain if argument in VERBS]
    if len(verbs) > 1:
        raise UserError("list or table, not both")
    groups = {name: group for name, group in GROUPS.items() if name in plain} or GROUPS
    published = TABLE if "published" in plain else None

    def drawn(results: Results) -> str:
        return report(groups, results, may_drive=not verbs)

    end(run_grid("".join(verbs), groups, FOLDER, drawn, published))


def report(groups: dict[str, Group], results: Results, may_drive: bool) -> str:
    """The runs, and what the controller does alone in their rooms and with their gains."""
    configs = [train_config(group.options) for group in groups.values()]
    assisted = [config for config in configs if config.agent.assisted]
    alone = controller_alone.table(controller_alone.measured(assisted, FOLDER, may_drive))
    if assisted and not alone:
        alone = "The controller alone has not been driven here yet; without the word table it is."
    return "\n\n".join(part for part in (runs_table(groups, results), LEGEND, alone) if part)


if __name__ == "__main__":
    run(main, f"{__doc__}\nGroups: {', '.join(GROUPS)}")
