"""Evaluate: `python -m asddpg.evaluate run=<run_dir> episodes=200`.

A baseline needs no run: `python -m asddpg.evaluate agent=controller task=nav_complex`.
"""

import dataclasses
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException

from asddpg import checkpoint
from asddpg.build import action_bounds, check_device, controller_for, make_agent, make_environment, prepare_torch
from asddpg.compose import BASELINES, evaluate_config, first_line, option_names, train_config
from asddpg.config import ControllerConfig, EvaluateConfig, TrainConfig, check
from asddpg.drivers import FixedDriver, actor_alone, controller_alone, random_actor, with_switch
from asddpg.errors import UserError
from asddpg.evaluation import evaluate, table
from asddpg.observers.progress import EpisodeBar
from asddpg.program import run
from asddpg.run_folder import RunFolder, open_run_folder, read_config, write_json
from asddpg.streams import stream
from asddpg.train import hash_of, versions
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
        _evaluate_run(config, open_run_folder(config.run))
    else:
        raise UserError(f"evaluate what? run=<run_dir>, or agent={'|'.join(BASELINES)} with task=")


def _evaluate_run(config: EvaluateConfig, folder: RunFolder) -> None:
    if config.controller != ControllerConfig():
        raise UserError("a run brings its own controller; controller.* is for agent=controller")
    trained, made_with = trained_config(folder)
    trained.device = config.device
    is_other_task = config.task not in (None, trained.task.name)
    trained.task.name = config.task or trained.task.name
    environment = make_environment(trained.task, trained.reward)
    agent = make_agent(trained, environment)
    step = checkpoint.load(folder.checkpoint(config.checkpoint), agent)
    if config.driver == "switch" and agent.controller is None:
        raise UserError("driver=switch needs a run with a controller, and this one is DDPG; driver=actor works")
    driver = with_switch(agent) if config.driver == "switch" else actor_alone(agent)
    if not is_other_task and hash_of(environment) != made_with.get("model_hash"):
        print("note: the scene's model is not the one this run was trained on")
    what = f"{folder.path}, {config.checkpoint} checkpoint (step {step}), driver {config.driver}"
    _drive(config, trained, environment, driver, what, folder.evaluation)


def trained_config(folder: RunFolder) -> tuple[TrainConfig, dict[str, str]]:
    """The configuration that a run was trained with, and what it was made with; UserError where it is damaged."""
    values, made_with = read_config(folder)
    try:
        merged = OmegaConf.merge(OmegaConf.structured(TrainConfig), values)
        trained = OmegaConf.to_object(merged)
        assert isinstance(trained, TrainConfig)
        check(trained)
    except (OmegaConfBaseException, UserError) as error:
        raise UserError(f"{folder.config} is not a configuration of this version: {first_line(error)}") from error
    if trained.task.name not in ALL_TASKS:
        raise UserError(f"{folder.config} names no task of this version: {trained.task.name!r}")
    return trained, made_with


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
    _drive(config, defaults, environment, driver, f"{config.agent} on {config.task}", Path("evaluation.json"))


def _drive(
    config: EvaluateConfig, trained: TrainConfig, environment: gymnasium.Env, driver: FixedDriver, what: str, path: Path
) -> None:
    pairs, pairs_name = _pairs(config, trained.task.name, trained.task.goal_radius)
    if not os.access(path.parent, os.W_OK):
        raise UserError(f"{path} cannot be written: the folder is not writable")
    bar = EpisodeBar(len(pairs))
    figures = evaluate(environment, driver, pairs, trained.task.control_timestep, (bar,))
    bar.close()
    title = config.agent or config.driver
    print(f"{what}, {trained.task.name}, {pairs_name}\n{table({title: figures})}")
    content: dict[str, Any] = {
        "what": what,
        "driver": title,
        "task": trained.task.name,
        "set": pairs_name,
        **figures.as_dict(),
    }
    content |= {"controller": dataclasses.asdict(config.controller)} if config.agent == "controller" else {}
    write_json(path, content | versions() | {"model_hash": hash_of(environment)})
    print(f"written to {path}")


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
