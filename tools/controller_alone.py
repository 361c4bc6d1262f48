"""The controller alone on the stored test sets: measured once, kept, and put into a table."""

import dataclasses
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from asddpg.build import controller_for, make_environment
from asddpg.config import TrainConfig
from asddpg.drivers import controller_alone
from asddpg.evaluation import evaluate
from asddpg.intervals import Estimate
from asddpg.run_folder import write_json
from asddpg.train import hash_of, versions
from tasks.fresh_pairs import stored_pairs
from tools.run_tables import Column, markdown

FIGURES = {
    "reach_rate": Column("reach"),
    "crash_rate": Column("crash"),
    "timeout_rate": Column("time-out"),
    "mean_time": Column("mean time (s)", "{:.1f}", is_share=False),
    "spl": Column("SPL"),
}


def title_of(config: TrainConfig) -> str:
    """Room and gains."""
    return f"{config.task.name}, P({', '.join(f'{gain:g}' for gain in config.controller.gains)})"


def measured(configs: Iterable[TrainConfig], folder: Path, may_drive: bool) -> dict[str, Mapping[str, Any]]:
    """Figures by room and gains, driven where they are not kept yet or no longer fit; left out if that may not be."""
    found: dict[str, Mapping[str, Any]] = {}
    for config in configs:
        path = (
            folder / f"controller_{config.task.name}_{'_'.join(f'{gain:g}' for gain in config.controller.gains)}.json"
        )
        content = found.get(title_of(config)) or _kept(path, config) or (_drive(path, config) if may_drive else None)
        if content:
            found[title_of(config)] = content
    return found


def _asked(config: TrainConfig) -> dict[str, Any]:
    return {"task": dataclasses.asdict(config.task), "controller": dataclasses.asdict(config.controller)}


def _kept(path: Path, config: TrainConfig) -> Mapping[str, Any] | None:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    fits = isinstance(content, dict) and {key: content.get(key) for key in ("task", "controller")} == _asked(config)
    return content if fits else None


def _drive(path: Path, config: TrainConfig) -> Mapping[str, Any]:
    environment = make_environment(config.task, config.reward)
    driver = controller_alone(controller_for(environment, config.controller))
    pairs = stored_pairs(config.task.name, "test", config.task.goal_radius)
    figures = evaluate(environment, driver, pairs, config.task.control_timestep)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_json(path, {**_asked(config), **figures.as_dict(), **versions(), "model_hash": hash_of(environment)})
    print(f"measured the controller alone: {title_of(config)}", flush=True)
    return json.loads(path.read_text(encoding="utf-8"))  # type: ignore[no-any-return]


def table(found: Mapping[str, Mapping[str, Any]]) -> str:
    """A row for each room and gains, or nothing."""
    if not found:
        return ""
    rows = [
        [
            title,
            *(column.cell(Estimate(content[key]["value"], *content[key]["ci95"])) for key, column in FIGURES.items()),
        ]
        for title, content in found.items()
    ]
    header = ["controller alone", *(column.title for column in FIGURES.values())]
    return f"{markdown(header, rows)}\n\nIn brackets 95 % intervals over the stored test pairs, Wilson's for rates."
