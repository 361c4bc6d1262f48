"""Evaluate: `python -m asddpg.evaluate run=<run_dir> episodes=200`.

A policy that the project brings along is run=pretrained:nav_complex. A baseline needs no run:
`python -m asddpg.evaluate agent=controller task=nav_complex`.
"""

import dataclasses
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from omegaconf import OmegaConf
from tqdm import tqdm

from asddpg.build import make_cameras, navigation_env
from asddpg.command_line import evaluate_config, option_names
from asddpg.config import EvaluateConfig
from asddpg.episodes.evaluation import EvaluationResult, evaluate, table
from asddpg.errors import UserError
from asddpg.observers.progress import EpisodeBar
from asddpg.policy_setup import Driving, open_driving
from asddpg.program import run
from asddpg.recording.how_to_open import how_to_open
from asddpg.runs.run_folder import unused_folder, write_json
from tasks.evaluation_pairs import fresh_pairs, stored_pairs
from tasks.room_geometry.held_out import Pair


def main(arguments: Sequence[str]) -> None:
    """Compose, drive, print the table, write evaluation.json."""
    config = evaluate_config(arguments)
    driving = open_driving(config, "evaluate", config.seed or 0)
    task = driving.config.task
    pairs, pairs_name = _pairs(config, task.name, task.goal_radius)
    if not os.access(driving.evaluation.parent, os.W_OK):
        raise UserError(f"{driving.evaluation} cannot be written: the folder is not writable")
    folder = unused_folder(driving.evaluation.parent / "evaluated_episodes")
    cameras = make_cameras(config.record, navigation_env(driving.environment))
    recorder = driving.recorder(config.record, folder, pairs_name, tqdm.write, cameras)
    bar = EpisodeBar(len(pairs))
    try:
        result = evaluate(driving.environment, driving.driver, pairs, task.control_timestep, (bar, recorder))
    finally:
        recorder.close()
        bar.close()
    print(f"{driving.what}, {task.name}, {pairs_name}\n{table({driving.name: result})}")
    write_json(driving.evaluation, _content(config, driving, pairs_name, result))
    print(f"written to {driving.evaluation}")
    if recorder.files:
        print(how_to_open(recorder.files, folder))


def _content(config: EvaluateConfig, driving: Driving, pairs_name: str, result: EvaluationResult) -> dict[str, Any]:
    content: dict[str, Any] = {
        "what": driving.what,
        "driver": driving.name,
        "task": driving.config.task.name,
        "set": pairs_name,
        **result.as_dict(),
    }
    content |= {"controller": dataclasses.asdict(config.controller)} if config.agent == "controller" else {}
    return content | driving.current_versions()


def _pairs(config: EvaluateConfig, task_name: str, goal_radius: float) -> tuple[Sequence[Pair], str]:
    if config.seed is not None:
        rng = np.random.default_rng(config.seed)
        return fresh_pairs(
            task_name, rng, config.episodes, goal_radius
        ), f"{config.episodes} fresh pairs, seed {config.seed}"
    stored = stored_pairs(task_name, "test", goal_radius)
    if config.episodes > len(stored):
        raise UserError(f"the stored test set has {len(stored)} pairs, not {config.episodes}; seed= draws fresh ones")
    return stored[: config.episodes], f"{config.episodes} stored test pairs"


if __name__ == "__main__":
    run(main, f"{__doc__}\n\nOptions: {', '.join(option_names(OmegaConf.structured(EvaluateConfig)))}")
