"""Ship a trained policy: `python -m tools.publish run=runs/mine name=nav_complex`.

Writes models/pretrained/<name>: the weights, the configuration, what it reaches on the stored test pairs, and a card.
"""

import dataclasses
import json
import re
import shutil
from collections.abc import Sequence
from dataclasses import MISSING, dataclass
from pathlib import Path

import gymnasium

from asddpg.algorithm.agent import AsDDPG
from asddpg.atomic_write import claim_folder, locked
from asddpg.build import controller_for, make_agent, make_environment, prepare_torch
from asddpg.config import ControllerConfig, TrainConfig
from asddpg.episodes.drivers import FixedDriver, actor_alone, controller_alone
from asddpg.episodes.evaluation import EvaluationResult, evaluate, table
from asddpg.errors import UserError
from asddpg.messages import print_line
from asddpg.observers.progress import count_episodes
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.runs import pretrained, weights_file
from asddpg.runs.loading import Trained, open_trained
from asddpg.runs.pretrained import PretrainedFolder
from asddpg.runs.provenance import environment_hash, versions
from asddpg.runs.run_folder import config_text, open_run_folder, write_json
from tasks.evaluation_pairs import stored_pairs
from tasks.options import Range, between, one_of, option
from tasks.registry import ANYWHERE
from tools.publishing.card import Facts, arguments_of, card
from tools.publishing.failures import DrivenEpisode, EndingsLog, report
from tools.publishing.places import elsewhere_table, generator_table

MAX_WEIGHT_BYTES = 3_000_000  # bytes of weights: the repository stays small
STORED = 200  # test pairs of a task of one room
MOST_STORED = 1000  # of nav_anywhere


@dataclass(frozen=True)
class PublishArguments:
    """The run to ship, and under which name."""

    run: str = option(MISSING, "Folder of a finished run, such as runs/mine.")
    name: str = option(
        MISSING,
        "Name of the policy, as in run=pretrained:<name>.",
        Range(lambda name: bool(re.fullmatch(r"[a-z][a-z0-9_]*", name)), "small letters, digits and _, as nav_complex"),
    )
    checkpoint: str = option("last", "Checkpoint of the run.", one_of("last", "best"))
    episodes: int = option(
        STORED,
        "Stored test pairs to drive, the first so many.",
        between(1, MOST_STORED, ", the size of the stored test set of nav_anywhere; other sets have 200"),
    )
    overwrite: bool = option(False, "Whether it replaces a policy of that name.")
    note: str | None = option(
        None, 'A sentence for the card: how the seed was chosen, such as "Seed 0 of five, whose mean is 0.95."'
    )


@prepare_torch()
def main(arguments: Sequence[str]) -> None:
    """Export, test what was exported, write the card; the folder is whole or not there."""
    parsed = parse_arguments(PublishArguments, arguments)
    folder = PretrainedFolder(pretrained.FOLDER / parsed.name)
    _check_overwrite(parsed)
    seconds = _training_seconds(parsed)
    trained = open_trained(parsed.run, parsed.checkpoint, None)
    if trained.config.controller.type != ControllerConfig().type:
        raise UserError(
            f"the controller {trained.config.controller.type} is not shipped, so neither is what it trained"
        )
    arguments_of(trained.config)  # an error before the driving, which takes minutes
    part = PretrainedFolder(claim_folder(folder.path.with_name(f".{parsed.name}.part")))
    try:
        _fill(part, parsed, trained, seconds)
        with locked(folder.path.parent):
            _check_overwrite(parsed)  # again: another process may have published meanwhile
            _replace(folder.path, part.path)
    finally:
        shutil.rmtree(part.path, ignore_errors=True)
    print_line(f"written to {folder.path}; evaluate it: python -m asddpg.evaluate run=pretrained:{parsed.name}")


def _check_overwrite(parsed: PublishArguments) -> None:
    if (pretrained.FOLDER / parsed.name).exists() and not parsed.overwrite:
        raise UserError(f"there is a pretrained policy {parsed.name!r} already; overwrite=true replaces it")


def _training_seconds(parsed: PublishArguments) -> float:
    run_folder = open_run_folder(parsed.run)
    if not run_folder.resources.is_file():
        raise UserError(f"the run {parsed.run} is not finished: it has no {run_folder.resources.name}")
    try:
        return float(json.loads(run_folder.resources.read_text(encoding="utf-8"))["training_seconds"])
    except (ValueError, KeyError, TypeError) as error:
        raise UserError(f"{run_folder.resources} is damaged or not written by asddpg.train") from error


def _fill(part: PretrainedFolder, parsed: PublishArguments, trained: Trained, seconds: float) -> None:
    config = dataclasses.replace(trained.config, device="cpu", run_dir=None)
    environment = make_environment(config.task, config.reward)
    agent, step = _export(part, trained, config, environment)
    part.config.write_text(config_text(config, trained.provenance), encoding="utf-8")
    metrics, drives = _test(config, environment, agent, parsed.episodes)
    print_line(table(metrics))
    scene = environment_hash(environment)
    content: dict[str, object] = {
        "task": config.task.name,
        "set": f"{len(drives)} stored test pairs",
        "checkpoint": parsed.checkpoint,
        "step": step,
        **{title: result.as_dict() for title, result in metrics.items()},
        "outcomes": [drive.outcome for drive in drives],
        "failures": [drive.as_dict() for drive in drives if drive.failed],
        **versions(),
        "model_hash": scene,
    }
    write_json(part.test, content)
    facts = Facts(
        name=parsed.name,
        config=trained.config,
        checkpoint=parsed.checkpoint,
        step=step,
        seconds=seconds,
        note=" ".join((parsed.note or "").split()),
        provenance=trained.provenance,
        tested_scene=scene,
        metrics=metrics,
        failures=report(drives),
        elsewhere=_drive_elsewhere(config, agent, drives, parsed.episodes),
    )
    part.card.write_text(card(facts), encoding="utf-8")


def _export(
    part: PretrainedFolder, trained: Trained, config: TrainConfig, environment: gymnasium.Env
) -> tuple[AsDDPG, int]:
    """Write the weights; gives an agent that has them from that file, so that what is tested is what is shipped."""
    learned = make_agent(config, environment)
    step = weights_file.load_into(trained.weights, learned.networks)
    weights_file.save(part.weights, learned.networks, step, with_critic=False)
    if part.weights.stat().st_size > MAX_WEIGHT_BYTES:
        size = f"{part.weights.stat().st_size / 1e6:.1f} MB"
        raise UserError(
            f"the weights take {size}, above the {MAX_WEIGHT_BYTES / 1e6:g} MB shipped at most; narrow network.widths"
        )
    agent = make_agent(config, environment)
    return agent, weights_file.load_into(part.weights, agent.networks)


def _test(
    config: TrainConfig, environment: gymnasium.Env, agent: AsDDPG, episodes: int
) -> tuple[dict[str, EvaluationResult], list[DrivenEpisode]]:
    """Results by driver, and the episodes of the actor alone."""
    task = config.task
    pairs = stored_pairs(task.name, "test", task.goal_radius, robot=task.robot)[:episodes]
    drivers = {"actor": actor_alone(agent)}
    if agent.controller is not None:
        drivers["switch"] = FixedDriver(agent.decide_greedily)
    drivers["controller"] = controller_alone(controller_for(environment, config.controller))
    logs = {title: EndingsLog() for title in drivers}
    results = {
        title: evaluate(environment, driver, count_episodes(pairs), config.task.control_timestep, (logs[title],))
        for title, driver in drivers.items()
    }
    return results, logs["actor"].drives(pairs)


def _drive_elsewhere(config: TrainConfig, agent: AsDDPG, drives: Sequence[DrivenEpisode], episodes: int) -> str:
    """Of a policy of changing rooms: where it drives, Markdown; of another nothing."""
    if config.task.name != ANYWHERE:
        return ""
    other = elsewhere_table(config, actor_alone(agent), episodes)
    return f"By generator:\n\n{generator_table(drives)}\n\nIn the rooms of the other tasks:\n\n{other}"


def _replace(path: Path, part: Path) -> None:
    """Put the finished folder where it belongs; the old one is gone only when the new one stands."""
    old = path.with_name(f".{path.name}.old")
    shutil.rmtree(old, ignore_errors=True)
    if path.exists():
        path.rename(old)
    part.rename(path)
    shutil.rmtree(old, ignore_errors=True)


if __name__ == "__main__":
    run(main, help_text(__doc__, PublishArguments))
