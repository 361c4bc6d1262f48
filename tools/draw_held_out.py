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
from tasks.evaluation_pairs import draw_pairs, draw_room_pairs
from tasks.registry import ANYWHERE
from tasks.room_geometry.held_out import FOLDER, Pair
from tasks.rooms.changing_room import GENERATED

SIZES = {"validation": 50, "test": 200}
SEED = 2018
# Of nav_anywhere: the first number, rooms, pairs in each. Trainings have rooms from 1000 on.
ANYWHERE_ROOMS = {"validation": (900, 50, 1), "test": (0, 500, 2)}


def stored_text(task_name: str) -> str:
    """The file of a task's sets: JSON, one pair a line."""
    rng = np.random.default_rng([SEED, *task_name.encode()])
    parts = []
    for name in SIZES:
        pairs = _anywhere_pairs(name) if task_name == ANYWHERE else _pairs(task_name, name, rng)
        lines = [json.dumps({key: value for key, value in vars(pair).items() if value != ""}) for pair in pairs]
        parts.append(f'"{name}": [\n' + ",\n".join(lines) + "\n]")
    return "{" + ",\n".join(parts) + "}\n"


def _pairs(task_name: str, set_name: str, rng: np.random.Generator) -> tuple[Pair, ...]:
    return draw_pairs(task_name, rng, SIZES[set_name], GOAL_RADIUS, held_out=np.zeros((0, 2)))


def _anywhere_pairs(set_name: str) -> list[Pair]:
    """Of rooms of every generator in turn, so that the first ones are a sample of all."""
    first, rooms, pairs = ANYWHERE_ROOMS[set_name]
    names = [f"{GENERATED[index % len(GENERATED)]}:{first + index // len(GENERATED)}" for index in range(rooms)]
    return [pair for name in names for pair in draw_room_pairs(name, pairs, GOAL_RADIUS)]


def main(arguments: Sequence[str]) -> None:
    """Write the sets of every task."""
    parse_arguments(NoArguments, arguments)
    for task_name in ALL_TASKS:
        path = FOLDER / f"{task_name}.json"
        path.write_text(stored_text(task_name))
        print_line(f"{path}: {path.read_text().count('start')} pairs")


if __name__ == "__main__":
    run(main, help_text(__doc__, NoArguments))
