"""Draw the stored evaluation sets: `python -m tools.draw_held_out`.

A repeated run writes the same files. Do not change them: results on other sets are not comparable.
"""

import json
from collections.abc import Sequence

import numpy as np

from asddpg.messages import print_line
from asddpg.options.help_text import help_text
from asddpg.options.parsing import NoArguments, parse_arguments
from asddpg.program import run
from tasks import ALL_TASKS
from tasks.constants import GOAL_RADIUS
from tasks.evaluation_pairs import draw_pairs
from tasks.room_geometry.held_out import FOLDER

SIZES = {"validation": 50, "test": 200}
SEED = 2018


def stored_text(task_name: str) -> str:
    """The file of a task's sets: JSON, one pair a line."""
    rng = np.random.default_rng([SEED, *task_name.encode()])
    parts = []
    for name, size in SIZES.items():
        pairs = draw_pairs(task_name, rng, size, GOAL_RADIUS, held_out=np.zeros((0, 2)))
        lines = [
            json.dumps({"start": pair.start, "goal": pair.goal, "shortest_path": pair.shortest_path}) for pair in pairs
        ]
        parts.append(f'"{name}": [\n' + ",\n".join(lines) + "\n]")
    return "{" + ",\n".join(parts) + "}\n"


def main(arguments: Sequence[str]) -> None:
    """Write the sets of every task."""
    parse_arguments(NoArguments, arguments)
    for task_name in ALL_TASKS:
        path = FOLDER / f"{task_name}.json"
        path.write_text(stored_text(task_name))
        print_line(f"{path}: {', '.join(f'{size} {name}' for name, size in SIZES.items())} pairs")


if __name__ == "__main__":
    run(main, help_text(__doc__, NoArguments))
