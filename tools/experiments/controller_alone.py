"""The controller alone on the stored test sets: measured once, kept, and put into a table."""

import dataclasses
import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from asddpg.build import controller_for, make_environment
from asddpg.config import ControllerConfig, TaskConfig, TrainConfig
from asddpg.episodes.drivers import controller_alone
from asddpg.episodes.evaluation import ROWS, cell, evaluate
from asddpg.episodes.intervals import Estimate
from asddpg.runs.provenance import versions
from asddpg.runs.run_folder import write_json
from tasks.evaluation_pairs import stored_pairs
from tools.experiments.current_scenes import scene_today
from tools.experiments.markdown import markdown
from tools.experiments.run_store import flat

FIGURES = {field: row for field, row in ROWS.items() if field != "metric"}


def title_of(config: TrainConfig) -> str:
    """Room, controller, gains, and what else the task has that its default has not."""
    gains = ", ".join(str(gain).removesuffix(".0") for gain in config.controller.gains)
    kind = config.controller.type
    name = "P" if kind == ControllerConfig().type else kind
    return ", ".join([config.task.name, f"{name}({gains})", *_of_its_own(config.task)])


def _of_its_own(task: TaskConfig) -> list[str]:
    defaults = dict(flat(dataclasses.asdict(TaskConfig(name=task.name))))
    return [f"{name}={value}" for name, value in flat(dataclasses.asdict(task)) if value != defaults[name]]


def path_of(config: TrainConfig, folder: Path) -> Path:
    """Where its figures are kept."""
    return folder / f"controller_{re.sub(r'[^A-Za-z0-9.=-]+', '_', title_of(config)).strip('_')}.json"


def measured(configs: Iterable[TrainConfig], folder: Path, may_drive: bool) -> dict[str, Mapping[str, Any]]:
    """Figures by title, driven where they are not kept yet or no longer fit; left out if that may not be."""
    found: dict[str, Mapping[str, Any]] = {}
    for config in configs:
        title, path = title_of(config), path_of(config, folder)
        content = found.get(title) or _kept(path, config) or (_drive(path, config) if may_drive else None)
        if content:
            found[title] = content
    return found


def _asked(config: TrainConfig) -> dict[str, Any]:
    task = config.task
    return {
        "task": dataclasses.asdict(task),
        "controller": dataclasses.asdict(config.controller),
        "model_hash": scene_today(task.name, task.laser.num_beams),
    }


def _kept(path: Path, config: TrainConfig) -> Mapping[str, Any] | None:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    asked = _asked(config)
    return content if isinstance(content, dict) and {key: content.get(key) for key in asked} == asked else None


def _drive(path: Path, config: TrainConfig) -> Mapping[str, Any]:
    environment = make_environment(config.task, config.reward)
    driver = controller_alone(controller_for(environment, config.controller))
    pairs = stored_pairs(config.task.name, "test", config.task.goal_radius)
    metrics = evaluate(environment, driver, pairs, config.task.control_timestep)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_json(path, {**_asked(config), **metrics.as_dict(), **versions()})
    print(f"measured the controller alone: {title_of(config)}", flush=True)
    return json.loads(path.read_text(encoding="utf-8"))  # type: ignore[no-any-return]


def table(found: Mapping[str, Mapping[str, Any]]) -> str:
    """A row for each room and gains, or nothing."""
    if not found:
        return ""
    rows = [
        [
            title,
            *(cell(Estimate(content[key]["value"], *content[key]["ci95"]), form) for key, (_, form) in FIGURES.items()),
        ]
        for title, content in found.items()
    ]
    header = ["controller alone", *(title for title, _ in FIGURES.values())]
    return f"{markdown(header, rows)}\n\nIn brackets 95 % intervals over the stored test pairs, Wilson's for rates."
