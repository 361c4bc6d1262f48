"""Evaluate: `python -m asddpg.evaluate run=<run_dir> episodes=200`.

A policy that the project brings along is run=pretrained:nav_complex. A baseline needs no run:
`python -m asddpg.evaluate agent=controller task=nav_complex`.
"""

import dataclasses
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from omegaconf import OmegaConf

from asddpg.build import (
    action_bounds,
    check_device,
    controller_for,
    make_agent,
    make_cameras,
    make_environment,
    prepare_torch,
)
from asddpg.compose import BASELINES, evaluate_config, option_names, train_config
from asddpg.config import ControllerConfig, EvaluateConfig, RecordEvaluationConfig, TrainConfig
from asddpg.drivers import FixedDriver, actor_alone, controller_alone, random_actor, with_switch
from asddpg.errors import UserError
from asddpg.evaluation import evaluate, table
from asddpg.observers.progress import EpisodeBar
from asddpg.program import run
from asddpg.recording.recorder import Recorder, Selection, each
from asddpg.run_folder import config_text, write_json
from asddpg.streams import stream
from asddpg.train import hash_of, provenance_of, versions, watched
from asddpg.trained import file_hash, open_trained
from tasks import ALL_TASKS
from tasks.fresh_pairs import fresh_pairs, stored_pairs
from tasks.held_out import Pair


def main(words: Sequence[str]) -> None:
    """Compose, drive, print the table, write evaluation.json."""
    config = evaluate_config(words)
    check_device(config.device)
    prepare_torch()
    if config.task is not None and config.task not in ALL_TASKS:
        raise UserError(f"there is no task {config.task!r}; there are {', '.join(ALL_TASKS)}")
    if config.agent is not None:
        _evaluate_baseline(config)
    elif config.run is not None:
        _evaluate_run(config, config.run)
    else:
        raise UserError(
            f"evaluate what? run=<run_dir> or run=pretrained:<name>, or agent={'|'.join(BASELINES)} with task="
        )


def _evaluate_run(config: EvaluateConfig, run: str) -> None:
    if config.controller != ControllerConfig():
        raise UserError("a run brings its own controller; controller.* is for agent=controller")
    opened = open_trained(run, config.checkpoint)
    trained = opened.config
    trained.device = config.device
    is_other_task = config.task not in (None, trained.task.name)
    trained.task.name = config.task or trained.task.name
    environment = make_environment(trained.task, trained.reward)
    agent = make_agent(trained, environment)
    step = opened.load_into(agent)
    if config.driver == "switch" and agent.controller is None:
        raise UserError("driver=switch needs a run with a controller, and this one is DDPG; driver=actor works")
    driver = with_switch(agent) if config.driver == "switch" else actor_alone(agent)
    if not is_other_task and hash_of(environment) != opened.made_with.get("model_hash"):
        print("note: the scene's model is not the one this run was trained on")
    what = f"{opened.title} (step {step}), driver {config.driver}"
    checkpoint = {"checkpoint": f"{opened.title}, step {step}", "weights_sha256": file_hash(opened.weights)}
    _drive(config, trained, environment, driver, what, opened.evaluation, checkpoint)


def _evaluate_baseline(config: EvaluateConfig) -> None:
    if config.agent not in BASELINES:
        raise UserError(
            f"there is no baseline {config.agent!r}; there are {', '.join(BASELINES)}; a trained agent is run="
        )
    if config.run is not None or config.task is None:
        raise UserError(f"agent={config.agent} needs task= and no run=, such as task={ALL_TASKS[-1]}")
    if (config.driver, config.checkpoint) != ("actor", "last"):
        raise UserError("driver= and checkpoint= belong to run=; a baseline has neither")
    defaults = train_config([f"task={config.task}"])
    environment = make_environment(defaults.task, defaults.reward)
    if config.agent == "controller":
        driver = controller_alone(controller_for(environment, config.controller))
    else:
        driver = random_actor(*action_bounds(environment), stream(config.seed or 0, "exploration"))
    what = f"{config.agent} on {config.task}"
    _drive(config, defaults, environment, driver, what, Path("evaluation.json"), {"checkpoint": "none"})


def _drive(
    config: EvaluateConfig,
    trained: TrainConfig,
    environment: gymnasium.Env,
    driver: FixedDriver,
    what: str,
    path: Path,
    checkpoint: dict[str, str],
) -> None:
    pairs, pairs_name = _pairs(config, trained.task.name, trained.task.goal_radius)
    if not os.access(path.parent, os.W_OK):
        raise UserError(f"{path} cannot be written: the folder is not writable")
    cameras = make_cameras(config.record, watched(environment))
    title = config.agent or config.driver
    made_with = versions() | {"model_hash": hash_of(environment)}
    settings = config_text(dataclasses.asdict(trained), made_with)
    provenance = provenance_of(trained, settings, made_with, driver=title, pairs=pairs_name, **checkpoint)
    bar = EpisodeBar(len(pairs))
    folder = path.parent / "evaluated_episodes"
    selection = _selection(config.record)
    recorder = Recorder(folder, watched(environment), provenance, selection, bar.say, cameras=cameras)
    try:
        figures = evaluate(environment, driver, pairs, trained.task.control_timestep, (bar, recorder))
    finally:
        recorder.close()
        bar.close()
    print(f"{what}, {trained.task.name}, {pairs_name}\n{table({title: figures})}")
    content: dict[str, Any] = {
        "what": what,
        "driver": title,
        "task": trained.task.name,
        "set": pairs_name,
        **figures.as_dict(),
    }
    content |= {"controller": dataclasses.asdict(config.controller)} if config.agent == "controller" else {}
    write_json(path, content | made_with)
    print(f"written to {path}")
    if recorder.files:
        print(f"{recorder.files} episodes recorded in {folder}")


def _selection(wanted: RecordEvaluationConfig) -> Selection:
    # Who names outcomes alone wants all episodes that end so.
    every = wanted.every or (1 if wanted.outcomes and not wanted.only else 0)
    regularly = each(every)
    return Selection(lambda number: regularly(number) or number in wanted.only, wanted.outcomes)


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
