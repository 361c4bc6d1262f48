"""Run folders as a finished training leaves them, with figures made up."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from asddpg.runs.run_folder import config_text
from tools.experiments.runs import Group, Run


def finish(
    folder: Path,
    run: Run,
    *,
    success: float = 0.5,
    outcomes: Sequence[str] = ("reached", "crashed"),
    shares: Sequence[float] = (0.25,),
    validations: Sequence[float] = (0.5,),
    prefers: Sequence[float] | None = None,
    model_hash: str = "0123456789abcdef",
    provenance: Mapping[str, str] | None = None,
) -> Path:
    """Write a run: its episodes are equally long and fill its steps, outcomes and shares repeat over them.

    `prefers` is Q(controller) − Q(policy) by step; without it there is no steps.npz.
    """
    path = folder / run.name
    path.mkdir(parents=True)
    made = {"asddpg": "0.0.9", "model_hash": model_hash, **(provenance or {})}
    (path / "config.yaml").write_text(config_text(run.config, made), encoding="utf-8")
    (path / "metrics.csv").write_text("\n".join(_episodes(run.config.total_steps, outcomes, shares)) + "\n")
    rows = [f"{number + 1},{value},0,0" for number, value in enumerate(validations)]
    (path / "validation.csv").write_text("\n".join(["step,success_rate,collision_rate,metric", *rows]) + "\n")
    (path / "test.json").write_text(json.dumps({"last": _rates(success), "best": _rates(min(success + 0.1, 1))}))
    if prefers is not None:
        values = np.asarray(prefers, dtype=np.float32)
        np.savez(path / "steps.npz", q_policy=0 * values, q_controller=values)
    took = {"training_seconds": run.config.total_steps / 100, "peak_memory_mb": 500.0}
    (path / "resources.json").write_text(json.dumps(took))
    return path


def finish_group(folder: Path, group: Group, successes: Sequence[float], **made_up: Any) -> None:
    """Write the runs of a group, one for each of its first seeds."""
    for seed, success in zip(group.seeds, successes, strict=False):
        finish(folder, group.run(seed), success=success, **made_up)


def _episodes(total: int, outcomes: Sequence[str], shares: Sequence[float]) -> list[str]:
    length = total // 100
    lines = ["step,outcome,steps,controller_share"]
    for number in range(100):
        outcome, share = outcomes[number % len(outcomes)], shares[number * len(shares) // 100]
        lines.append(f"{(number + 1) * length},{outcome},{length},{share}")
    return lines


def _rates(success: float) -> dict[str, Any]:
    return {"success_rate": {"value": success, "ci95": [0, 1]}, "collision_rate": {"value": 1 - success}}
