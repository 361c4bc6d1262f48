"""Run folders as a finished training leaves them, with figures made up."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from tools.experiments.run_groups import Group
from tools.experiments.run_store import Settings


def finish(
    folder: Path,
    settings: Settings,
    *,
    reach: float = 0.5,
    outcomes: Sequence[str] = ("reached", "crashed"),
    shares: Sequence[float] = (0.25,),
    validations: Sequence[float] = (0.5,),
    prefers: Sequence[float] | None = None,
    model_hash: str = "0123456789abcdef",
) -> Path:
    """Write a run: its episodes are equally long and fill its steps, outcomes and shares repeat over them.

    `prefers` is Q(controller) − Q(policy) by step; without it there is no steps.npz.
    """
    folder.mkdir(parents=True)
    made = {"run_dir": "somewhere", "provenance": {"asddpg": "0.0.9", "model_hash": model_hash}}
    (folder / "config.yaml").write_text(yaml.safe_dump(settings | made, allow_unicode=True), encoding="utf-8")
    (folder / "metrics.csv").write_text("\n".join(_episodes(settings["total_steps"], outcomes, shares)) + "\n")
    rows = [f"{number + 1},{value},0,0" for number, value in enumerate(validations)]
    (folder / "validation.csv").write_text("\n".join(["step,success_rate,collision_rate,metric", *rows]) + "\n")
    (folder / "test.json").write_text(json.dumps({"last": _figures(reach), "best": _figures(min(reach + 0.1, 1))}))
    if prefers is not None:
        values = np.asarray(prefers, dtype=np.float32)
        np.savez(folder / "steps.npz", q_policy=0 * values, q_controller=values)
    took = {"training_seconds": settings["total_steps"] / 100, "peak_memory_mb": 500.0}
    (folder / "resources.json").write_text(json.dumps(took))
    return folder


def finish_group(folder: Path, name: str, group: Group, reaches: Sequence[float], **made_up: Any) -> None:
    """Write the runs of a group, one for each of its first seeds."""
    for seed, reach in zip(group.seeds, reaches, strict=False):
        finish(folder / f"{name}_seed{seed}", group.settings(seed), reach=reach, **made_up)


def _episodes(total: int, outcomes: Sequence[str], shares: Sequence[float]) -> list[str]:
    length = total // 100
    lines = ["step,outcome,steps,controller_share"]
    for number in range(100):
        outcome, share = outcomes[number % len(outcomes)], shares[number * len(shares) // 100]
        lines.append(f"{(number + 1) * length},{outcome},{length},{share}")
    return lines


def _figures(reach: float) -> dict[str, Any]:
    return {"success_rate": {"value": reach, "ci95": [0, 1]}, "collision_rate": {"value": 1 - reach, "ci95": [0, 1]}}
