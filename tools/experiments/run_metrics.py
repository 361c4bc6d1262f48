"""Metrics of a finished run: what they are called, and how its files give them."""

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from asddpg.config import TrainConfig
from asddpg.episodes.evaluation import cell
from asddpg.episodes.intervals import Estimate
from asddpg.errors import UserError
from asddpg.runs.run_folder import RunFolder
from asddpg.runs.safe_loading import check_packed
from tools.diagnosis.step_metrics import MAX_UNPACKED_BYTES

LAST_EPISODES = 200
VALIDATIONS_COUNTED = 5


@dataclass(frozen=True)
class Metric:
    """How a metric is shown; the interval of a rate or share is cut at 0 and 1, where it ends."""

    title: str
    form: str = "{:.3f}"
    is_share: bool = True

    def cell(self, estimate: Estimate) -> str:
        """A value with its interval, where it has one."""
        value, low, high = estimate
        if self.is_share and low is not None and high is not None:
            estimate = Estimate(value, max(low, 0.0), min(high, 1.0))
        return cell(estimate, self.form)


METRICS = {
    # Of the last 200 training episodes: noise on, controller as far as its schedule lets it.
    "success_training": Metric("success while training"),
    # Actor alone on the stored test pairs, checkpoint last or best.
    "success_last": Metric("success rate, last"),
    "collision_last": Metric("collision rate, last"),
    "success_best": Metric("success rate, best"),
    # Controller's share of the steps, by quarter of training and in its last tenth.
    "share_1": Metric("controller 1/4"),
    "share_2": Metric("2/4"),
    "share_3": Metric("3/4"),
    "share_4": Metric("4/4"),
    "share_end": Metric("controller, last 10 %"),
    # Share of the last tenth's steps where the switch rates the controller higher.
    "switch_prefers": Metric("switch prefers the controller"),
    # Mean success rate of five validations, and the best five less the last five.
    "last_five": Metric("last five validations"),
    "best_five": Metric("best five validations"),
    "swing": Metric("best less last five", is_share=False),
    "steps_per_second": Metric("steps/s", "{:.0f}", is_share=False),
    "memory_mb": Metric("memory (MB)", "{:.0f}", is_share=False),  # peak
}

Metrics = Mapping[str, float | None]  # by name; None where there was nothing to measure


def read_metrics(run: RunFolder, config: TrainConfig) -> Metrics:
    """Read the files of a finished run.

    Raises:
        UserError: one of them is damaged or not there.
    """
    try:
        episodes = _read_rows(run.metrics)
        # A short run may end before the first validation falls due.
        validations = _read_rows(run.validation) if run.validation.exists() else []
        resources = json.loads(run.resources.read_text(encoding="utf-8"))
        seconds = resources["training_seconds"]
        return {
            "success_training": _success_rate(episodes),
            **_test_rates(run.test, config),
            **_controller_shares(episodes, config),
            "switch_prefers": _switch_preference(run.steps, config.total_steps),
            **_stability([float(row["success_rate"]) for row in validations]),
            "steps_per_second": config.total_steps / seconds if seconds else None,
            "memory_mb": resources["peak_memory_mb"],
        }
    except (OSError, EOFError, ValueError, KeyError, TypeError, BadZipFile) as error:
        raise UserError(f"{run.path} lacks a metric; remove it to train it again") from error


def _read_rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _success_rate(episodes: Sequence[dict[str, str]]) -> float | None:
    outcomes = [row["outcome"] for row in episodes if row["outcome"] != "cut"][-LAST_EPISODES:]
    return outcomes.count("reached") / len(outcomes) if outcomes else None


def _test_rates(path: Path, config: TrainConfig) -> dict[str, Any]:
    if not config.test_episodes:
        return dict.fromkeys(("success_last", "collision_last", "success_best"))
    tested = json.loads(path.read_text(encoding="utf-8"))
    return {
        "success_last": tested["last"]["success_rate"]["value"],
        "collision_last": tested["last"]["collision_rate"]["value"],
        "success_best": tested["best"]["success_rate"]["value"],
    }


def _controller_shares(episodes: Sequence[dict[str, str]], config: TrainConfig) -> Metrics:
    """An episode counts where it ends."""
    ends = np.array([int(row["step"]) for row in episodes]) / config.total_steps
    steps = np.array([int(row["steps"]) for row in episodes])
    driven = steps * np.array([float(row["controller_share"]) for row in episodes])

    def share(begin: float, end: float) -> float | None:
        within = (ends > begin) & (ends <= end)
        return float(driven[within].sum() / steps[within].sum()) if config.agent.assisted and within.any() else None

    return {f"share_{q + 1}": share(q / 4, (q + 1) / 4) for q in range(4)} | {"share_end": share(0.9, 1.0)}


def _switch_preference(path: Path, total_steps: int) -> float | None:
    """Unlike the controller's share, the schedule that takes the controller away does not touch it."""
    if not path.exists():
        return None
    check_packed(path, MAX_UNPACKED_BYTES)
    # Opened here: of a damaged one np.load leaves its own open.
    with path.open("rb") as file, np.load(file, allow_pickle=False) as steps:
        q_policy, q_controller = (steps[name][round(0.9 * total_steps) :] for name in ("q_policy", "q_controller"))
    is_known = ~np.isnan(q_policy) & ~np.isnan(q_controller)
    return float(np.mean(q_controller[is_known] > q_policy[is_known])) if is_known.any() else None


def _stability(success_rates: Sequence[float]) -> Metrics:
    if not success_rates:
        return dict.fromkeys(("last_five", "best_five", "swing"))
    last = float(np.mean(success_rates[-VALIDATIONS_COUNTED:]))
    best = float(np.mean(sorted(success_rates)[-VALIDATIONS_COUNTED:]))
    return {"last_five": last, "best_five": best, "swing": best - last}
