"""Ship a trained policy: `python -m tools.publish run=runs/mine name=nav_complex`.

Writes models/pretrained/<name>: the weights, the configuration, what it reaches on the stored test pairs, and a card.
Options:

  run=runs/mine      folder of a finished run
  name=nav_complex   what run=pretrained:<name> will call it
  checkpoint=last    or best
  episodes=200       stored test pairs to drive
  overwrite=false    true replaces a policy of that name
  note="…"           a sentence for the card: how the seed was chosen, such as "Seed 0 of five, whose mean is 0.95."
"""

import dataclasses
import json
import re
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import gymnasium

from asddpg.algorithm.agent import AsDDPG
from asddpg.build import controller_for, make_agent, make_environment, prepare_torch
from asddpg.config import ControllerConfig, TrainConfig
from asddpg.episodes.drivers import FixedDriver, actor_alone, controller_alone, with_switch
from asddpg.episodes.evaluation import EvaluationResult, evaluate, table
from asddpg.errors import UserError
from asddpg.observers.progress import EpisodeBar
from asddpg.program import run
from asddpg.runs import policy_file, pretrained
from asddpg.runs.loading import Trained, open_trained
from asddpg.runs.pretrained import PretrainedFolder
from asddpg.runs.provenance import environment_hash, versions
from asddpg.runs.run_folder import config_text, open_run_folder, write_json
from tasks.evaluation_pairs import stored_pairs
from tasks.room_geometry.held_out import Pair
from tools.option_arguments import options_in
from tools.publishing.card import Facts, card
from tools.publishing.command_arguments import command_of
from tools.publishing.failures import DrivenEpisode, EndingsLog, report

OPTIONS = ("run", "name", "checkpoint", "episodes", "overwrite", "note")
MAX_WEIGHT_BYTES = 3_000_000  # bytes of weights: the repository stays small
STORED = 200  # test pairs of a task


@dataclass(frozen=True)
class Wish:
    """What is to be shipped under which name."""

    run: str
    name: str
    checkpoint: str
    episodes: int
    overwrite: bool
    note: str


@dataclass(frozen=True)
class Tested:
    """Figures by who drove, and every drive of the actor alone."""

    metrics: dict[str, EvaluationResult]
    drives: list[DrivenEpisode]
    scene: str


def wish(arguments: Sequence[str]) -> Wish:
    """Read the command line's words; UserError where one is wrong."""
    defaults = {"checkpoint": "last", "episodes": str(STORED), "overwrite": "false", "note": ""}
    options = defaults | options_in(arguments, OPTIONS)
    if "run" not in options or "name" not in options:
        raise UserError("publish which run under which name? run=runs/mine name=nav_complex")
    if not re.fullmatch(r"[a-z][a-z0-9_]*", options["name"]):
        raise UserError(f"name must be small letters, digits and _, such as nav_complex, not {options['name']!r}")
    for name, choices in (("checkpoint", ("last", "best")), ("overwrite", ("true", "false"))):
        if options[name] not in choices:
            raise UserError(f"{name} must be {' or '.join(choices)}, not {options[name]!r}")
    if not re.fullmatch(r"\d{1,3}", options["episodes"]) or not 1 <= int(options["episodes"]) <= STORED:
        raise UserError(f"episodes must be from 1 to {STORED}, the size of the stored test set")
    return Wish(
        run=options["run"],
        name=options["name"],
        checkpoint=options["checkpoint"],
        episodes=int(options["episodes"]),
        overwrite=options["overwrite"] == "true",
        note=" ".join(options["note"].split()),
    )


def main(arguments: Sequence[str]) -> None:
    """Export, test what was exported, write the card; the folder is whole or not there."""
    asked = wish(arguments)
    folder = PretrainedFolder(pretrained.FOLDER / asked.name)
    if folder.path.exists() and not asked.overwrite:
        raise UserError(f"there is a pretrained policy {asked.name!r} already; overwrite=true replaces it")
    seconds = _training_seconds(asked)
    trained = open_trained(asked.run, asked.checkpoint, None)
    if trained.config.controller.type != ControllerConfig().type:
        raise UserError(
            f"the controller {trained.config.controller.type} is not shipped, so neither is what it trained"
        )
    command = command_of(trained.config)
    prepare_torch()
    part = PretrainedFolder(folder.path.with_name(f".{asked.name}.part"))
    shutil.rmtree(part.path, ignore_errors=True)
    part.path.mkdir(parents=True)
    try:
        _fill(part, asked, trained, command, seconds)
        _replace(folder.path, part.path)
    finally:
        shutil.rmtree(part.path, ignore_errors=True)
    print(f"written to {folder.path}; evaluate it: python -m asddpg.evaluate run=pretrained:{asked.name}")


def _training_seconds(asked: Wish) -> float:
    run_folder = open_run_folder(asked.run)
    if not run_folder.resources.is_file():
        raise UserError(f"the run {asked.run} is not finished: it has no {run_folder.resources.name}")
    try:
        return float(json.loads(run_folder.resources.read_text(encoding="utf-8"))["training_seconds"])
    except (ValueError, KeyError, TypeError) as error:
        raise UserError(f"{run_folder.resources} is damaged or not written by asddpg.train") from error


def _fill(part: PretrainedFolder, asked: Wish, trained: Trained, command: str, seconds: float) -> None:
    config = dataclasses.replace(trained.config, device="cpu", run_dir=None)
    environment = make_environment(config.task, config.reward)
    agent, step = _export(part, trained, config, environment)
    part.config.write_text(config_text(dataclasses.asdict(config), trained.provenance), encoding="utf-8")
    tested = _test(config, environment, agent, asked.episodes)
    print(table(tested.metrics))
    write_json(part.test, _test_content(asked, config, step, tested))
    facts = Facts(
        name=asked.name,
        config=trained.config,
        command=command,
        checkpoint=asked.checkpoint,
        step=step,
        seconds=seconds,
        note=asked.note,
        provenance=trained.provenance,
        tested_scene=tested.scene,
        metrics=tested.metrics,
        failures=report(tested.drives),
    )
    part.card.write_text(card(facts), encoding="utf-8")


def _export(
    part: PretrainedFolder, trained: Trained, config: TrainConfig, environment: gymnasium.Env
) -> tuple[AsDDPG, int]:
    """Write the weights; gives an agent that has them from that file, so that what is tested is what is shipped."""
    learned = make_agent(config, environment)
    step = trained.load_into(learned)
    policy_file.save(part.weights, learned.networks, step)
    if part.weights.stat().st_size > MAX_WEIGHT_BYTES:
        size = f"{part.weights.stat().st_size / 1e6:.1f} MB"
        raise UserError(
            f"the weights take {size}, above the {MAX_WEIGHT_BYTES / 1e6:g} MB shipped at most; narrow network.widths"
        )
    agent = make_agent(config, environment)
    return agent, policy_file.load_into(part.weights, agent.networks)


def _test(config: TrainConfig, environment: gymnasium.Env, agent: AsDDPG, episodes: int) -> Tested:
    pairs = stored_pairs(config.task.name, "test", config.task.goal_radius)[:episodes]
    drivers = {"actor": actor_alone(agent)}
    if agent.controller is not None:
        drivers["switch"] = with_switch(agent)
    drivers["controller"] = controller_alone(controller_for(environment, config.controller))
    metrics, drives = {}, {}
    for title, driver in drivers.items():
        metrics[title], drives[title] = _drive(config, environment, driver, pairs)
    return Tested(metrics, drives["actor"], environment_hash(environment))


def _drive(
    config: TrainConfig, environment: gymnasium.Env, driver: FixedDriver, pairs: Sequence[Pair]
) -> tuple[EvaluationResult, list[DrivenEpisode]]:
    log, bar = EndingsLog(), EpisodeBar(len(pairs))
    metrics = evaluate(environment, driver, pairs, config.task.control_timestep, (log, bar))
    bar.close()
    return metrics, log.drives(pairs)


def _test_content(asked: Wish, config: TrainConfig, step: int, tested: Tested) -> dict[str, object]:
    return {
        "task": config.task.name,
        "set": f"{asked.episodes} stored test pairs",
        "checkpoint": asked.checkpoint,
        "step": step,
        **{title: metrics.as_dict() for title, metrics in tested.metrics.items()},
        "outcomes": [drive.outcome for drive in tested.drives],
        "failures": [drive.as_dict() for drive in tested.drives if drive.failed],
        **versions(),
        "model_hash": tested.scene,
    }


def _replace(path: Path, part: Path) -> None:
    """Put the finished folder where it belongs; the old one is gone only when the new one stands."""
    old = path.with_name(f".{path.name}.old")
    shutil.rmtree(old, ignore_errors=True)
    if path.exists():
        path.rename(old)
    part.rename(path)
    shutil.rmtree(old, ignore_errors=True)


if __name__ == "__main__":
    run(main, str(__doc__))
