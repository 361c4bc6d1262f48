"""The controller alone on the stored test sets: measured once, kept, and put into a table."""

import dataclasses
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from asddpg.build import controller_for, make_environment
from asddpg.config import ControllerConfig, TrainConfig
from asddpg.episodes.drivers import controller_alone
from asddpg.episodes.evaluation import ROWS, cell, evaluate
from asddpg.episodes.intervals import Estimate
from asddpg.messages import print_line
from asddpg.runs.run_folder import write_json
from tasks.evaluation_pairs import stored_pairs
from tools.experiments.runs import current_scene, differences, digest
from tools.experiments.tables import markdown

SHOWN = {name: row for name, row in ROWS.items() if name != "metric"}


def table(configs: Iterable[TrainConfig], folder: Path, may_drive: bool) -> str:
    """A row for each room and controller; one not kept in the folder yet is driven, or left out if that may not be.

    Nothing comes back where no row is left.
    """
    rows: dict[str, list[str]] = {}
    for config in configs:
        metrics = _measure(config, folder, may_drive)
        if metrics:
            figures = {name: Estimate(metrics[name]["value"], *metrics[name]["ci95"]) for name in SHOWN}
            rows[describe(config)] = [describe(config), *(cell(figures[name], SHOWN[name][1]) for name in SHOWN)]
    header = ["controller alone", *(title for title, _ in SHOWN.values())]
    note = "In brackets 95 % intervals over the stored test pairs, Wilson's for rates."
    return f"{markdown(header, rows.values())}\n\n{note}" if rows else ""


def describe(config: TrainConfig) -> str:
    """Room, controller, gains, and in what else the task differs from its default."""
    gains = ", ".join(str(gain).removesuffix(".0") for gain in config.controller.gains)
    name = "P" if config.controller.type == ControllerConfig().type else config.controller.type
    others = differences({"task": dataclasses.asdict(config.task)})
    named = [f"{name.removeprefix('task.')}={value}" for name, value in others.items() if name != "task.name"]
    return ", ".join([config.task.name, f"{name}({gains})", *named])


def _measure(config: TrainConfig, folder: Path, may_drive: bool) -> Mapping[str, Any] | None:
    task = config.task
    setting = {
        "task": dataclasses.asdict(task),
        "controller": dataclasses.asdict(config.controller),
        "model_hash": current_scene(task.name, task.laser.ring),
    }
    path = folder / f"controller_alone_{digest(setting)}.json"
    if not path.exists():
        if not may_drive:
            return None
        environment = make_environment(task, config.reward)
        driver = controller_alone(controller_for(environment, config.controller))
        pairs = stored_pairs(task.name, "test", task.goal_radius)
        result = evaluate(environment, driver, pairs, task.control_timestep)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_json(path, setting | result.as_dict())
        print_line(f"measured the controller alone: {describe(config)}")
    return json.loads(path.read_text(encoding="utf-8"))  # type: ignore[no-any-return]
