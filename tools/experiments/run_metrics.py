"""The figures of a finished run."""

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from asddpg.errors import UserError
from asddpg.runs.safe_loading import check_packed
from tools.diagnosis.step_metrics import MAX_UNPACKED_BYTES
from tools.experiments.run_store import StoredRun

LAST_EPISODES = 200
VALIDATIONS_COUNTED = 5


@dataclass(frozen=True)
class RunMetrics:
    """What a run gave; None where there was nothing to measure. Rates and shares are from 0 to 1."""

    # Of the last 200 training episodes: noise on, controller as far as its schedule lets it.
    success_training: float | None
    success_last: float | None  # actor alone on the stored test pairs, checkpoint last
    collision_last: float | None
    success_best: float | None  # the same, checkpoint best
    share_1: float | None  # controller's share of the steps, by quarter of training
    share_2: float | None
    share_3: float | None
    share_4: float | None
    share_end: float | None  # in the last tenth
    switch_prefers: float | None  # share of the last tenth's steps where the switch rates the controller higher
    last_five: float | None  # mean reach of the last five validations
    best_five: float | None  # of the best five
    swing: float | None  # best five less last five
    steps_per_second: float | None
    memory_mb: float | None  # peak


def read_run_metrics(run: StoredRun) -> RunMetrics:
    """Read a run's files.

    Raises:
        UserError: one of them is damaged or not there.
    """
    try:
        return _figures(run)
    except (OSError, EOFError, ValueError, KeyError, TypeError, BadZipFile) as error:
        raise UserError(f"{run.folder.path} lacks a figure; remove it to train it again") from error


def _figures(run: StoredRun) -> RunMetrics:
    episodes = _rows(run.folder.metrics)
    reaches = [float(row["success_rate"]) for row in _rows(run.folder.validation)] if _is_validated(run) else []
    resources = json.loads(run.folder.resources.read_text(encoding="utf-8"))
    total = run.settings["total_steps"]
    return RunMetrics(
        success_training=_reach(episodes),
        **_tested(run),
        **_shares(episodes, total, run.settings["agent"]["assisted"]),
        switch_prefers=_switch_prefers(run.folder.steps, total),
        **_stability(reaches),
        steps_per_second=total / resources["training_seconds"] if resources["training_seconds"] else None,
        memory_mb=resources["peak_memory_mb"],
    )


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _is_validated(run: StoredRun) -> bool:
    # A short run may end before the first validation falls due.
    return run.folder.validation.exists()


def _reach(episodes: Sequence[dict[str, str]]) -> float | None:
    outcomes = [row["outcome"] for row in episodes if row["outcome"] != "cut"][-LAST_EPISODES:]
    return outcomes.count("reached") / len(outcomes) if outcomes else None


def _tested(run: StoredRun) -> dict[str, Any]:
    if not run.settings["test_episodes"]:
        return {"success_last": None, "collision_last": None, "success_best": None}
    tested = json.loads(run.folder.test.read_text(encoding="utf-8"))
    return {
        "success_last": tested["last"]["success_rate"]["value"],
        "collision_last": tested["last"]["collision_rate"]["value"],
        "success_best": tested["best"]["success_rate"]["value"],
    }


def _shares(episodes: Sequence[dict[str, str]], total: int, is_assisted: bool) -> dict[str, Any]:
    """An episode counts where it ends."""
    ends = np.array([int(row["step"]) for row in episodes])
    steps = np.array([int(row["steps"]) for row in episodes])
    driven = steps * np.array([float(row["controller_share"]) for row in episodes])

    def share(begin: float, end: float) -> float | None:
        within = (ends > begin * total) & (ends <= end * total)
        return float(driven[within].sum() / steps[within].sum()) if is_assisted and within.any() else None

    return {f"share_{q + 1}": share(q / 4, (q + 1) / 4) for q in range(4)} | {"share_end": share(0.9, 1.0)}


def _switch_prefers(path: Path, total: int) -> float | None:
    """Unlike its share, the schedule that takes the controller away does not touch it."""
    if not path.exists():
        return None
    check_packed(path, MAX_UNPACKED_BYTES)
    # Opened here: of a damaged one np.load leaves its own open.
    with path.open("rb") as file, np.load(file, allow_pickle=False) as steps:
        q_policy, q_controller = (steps[name][round(0.9 * total) :] for name in ("q_policy", "q_controller"))
    weighed = ~np.isnan(q_policy) & ~np.isnan(q_controller)
    return float(np.mean(q_controller[weighed] > q_policy[weighed])) if weighed.any() else None


def _stability(reaches: Sequence[float]) -> dict[str, Any]:
    if not reaches:
        return {"last_five": None, "best_five": None, "swing": None}
    last = float(np.mean(reaches[-VALIDATIONS_COUNTED:]))
    best = float(np.mean(sorted(reaches)[-VALIDATIONS_COUNTED:]))
    return {"last_five": last, "best_five": best, "swing": best - last}
