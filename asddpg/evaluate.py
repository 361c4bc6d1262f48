"""Evaluate: `python -m asddpg.evaluate run=<run_dir> episodes=200`.

run=pretrained:nav_complex is a policy that the project ships. A baseline needs no run:
`python -m asddpg.evaluate agent=controller task=nav_complex`.
"""

import dataclasses
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from tqdm import tqdm

from asddpg.build import make_cameras, navigation_env, prepare_torch
from asddpg.command_line import driver_config
from asddpg.config import EvaluateConfig, TaskConfig
from asddpg.drivers.baselines import PLANNERS
from asddpg.drivers.driver_setup import DriverSetup, set_up_driver
from asddpg.episodes.evaluation import EvaluationResult, evaluate, table
from asddpg.errors import UserError
from asddpg.messages import ERR, print_line
from asddpg.observers.progress import count_episodes
from asddpg.options.help_text import help_text
from asddpg.planning.navigation_view import view_plan
from asddpg.program import run
from asddpg.recording.how_to_open import how_to_open
from asddpg.runs.provenance import current_versions
from asddpg.runs.room_pairs import kept_pairs
from asddpg.runs.run_folder import RunFolder, write_json
from tasks.evaluation_pairs import fresh_pairs, stored_pairs
from tasks.room_geometry.held_out import Pair
from tasks.rooms.reading import is_room


@prepare_torch()
def main(arguments: Sequence[str]) -> None:
    """Compose, drive, print the table, write evaluation.json."""
    config = driver_config(EvaluateConfig, arguments)
    setup = set_up_driver(config, "evaluate", config.seed or 0)
    task = setup.config.task
    pairs, pairs_name = _pairs(config, task)
    file = RunFolder(setup.out).evaluation
    cameras = make_cameras(config.record, navigation_env(setup.environment))
    notify = partial(tqdm.write, file=ERR)
    driver, episodes = setup.drivers[setup.name], count_episodes(pairs)
    read_plan = (lambda: view_plan(driver)) if setup.plans else None
    recorder = setup.recorder(config.record, "evaluated_episodes", pairs_name, notify, cameras, read_plan)
    try:
        result = evaluate(setup.environment, driver, episodes, task.control_timestep, (recorder,))
    finally:
        recorder.close()
    content = _content(config, setup, pairs_name, result)
    try:
        write_json(file, content | ({"recordings": recorder.folder.name} if recorder.files else {}), keeps_old=True)
    finally:  # a full disk does not take the result too
        print_line(f"{setup.title}, {task.name}, {pairs_name}\n{table({setup.name: result})}")
    print_line(f"written to {file}")
    if recorder.files:
        print_line(how_to_open(recorder.files, recorder.folder))


def _content(config: EvaluateConfig, setup: DriverSetup, pairs_name: str, result: EvaluationResult) -> dict[str, Any]:
    content = {"what": setup.title, "driver": setup.name, "task": setup.config.task.name, "set": pairs_name}
    led = config.agent == "waypoints" and config.run is None
    controller = {"controller": dataclasses.asdict(config.controller)} if config.agent == "controller" or led else {}
    planner = {"planner": dataclasses.asdict(config.planner)} if config.agent in PLANNERS else {}
    given = {name: value for name, value in vars(config.laser).items() if value is not None}
    laser = {"laser": dataclasses.asdict(setup.config.task.laser)} if given else {}
    return {**content, **result.as_dict(), **controller, **planner, **laser, **current_versions(setup.environment)}


def _pairs(config: EvaluateConfig, task: TaskConfig) -> tuple[Sequence[Pair], str]:
    if config.seed is not None:
        fresh = fresh_pairs(
            task.name, np.random.default_rng(config.seed), config.episodes, task.goal_radius, task.robot
        )
        return fresh, f"{config.episodes} fresh pairs, seed {config.seed}"
    kept = kept_pairs(config.run, task, "test")[: config.episodes]
    stored = kept or stored_pairs(task.name, "test", task.goal_radius, config.episodes, task.robot)
    if is_room(task.name):
        return stored, f"{len(stored)} test pair{'s' * (len(stored) > 1)} of the room"
    if config.episodes > len(stored):
        raise UserError(f"the stored test set has {len(stored)} pairs, not {config.episodes}; seed= draws fresh ones")
    return stored, f"{config.episodes} stored test pairs"


if __name__ == "__main__":
    run(main, help_text(__doc__, EvaluateConfig))
