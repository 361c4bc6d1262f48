"""Metrics of a finished run: what they are called, and how its files give them."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asddpg.config import TrainConfig
from asddpg.episodes.evaluation import cell
from asddpg.episodes.intervals import Estimate
from asddpg.errors import UserError
from asddpg.observers.metrics_log import read_rows
from asddpg.runs.run_folder import RunFolder
from tools.diagnosis.step_metrics import DAMAGE, read_columns

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
        resources = json.loads(run.resources.read_text(encoding="utf-8"))
        seconds = resources["training_seconds"]
        return (
            dict.fromkeys(METRICS)
            | _training_metrics(read_rows(run.metrics), config)
            | (_test_metrics(run.test) if config.test_episodes else {})
            | _validation_metrics(read_rows(run.validation))  # a short run may have none
            | {"switch_prefers": _switch_preference(run.steps, config) if run.steps.exists() else None}
            | {"steps_per_second": config.total_steps / seconds if seconds else None}
            | {"memory_mb": resources.get("peak_memory_mb")}
        )
    except DAMAGE as error:
        raise UserError(f"{run.path} lacks a metric; remove it to train it again") from error


def _training_metrics(episodes: Sequence[dict[str, str]], config: TrainConfig) -> dict[str, float | None]:
    if not episodes:
        raise ValueError("no episodes")
    outcomes = [row["outcome"] for row in episodes if row["outcome"] != "cut"][-LAST_EPISODES:]
    # For the controller's share an episode counts where it ends; the last step of all robots may exceed the total.
    ends = np.minimum(np.array([int(row["step"]) for row in episodes]) / config.total_steps, 1.0)
    steps = np.array([int(row["steps"]) for row in episodes])
    driven = steps * np.array([float(row["controller_share"]) for row in episodes])
    parts = {f"share_{q + 1}": (q / 4, (q + 1) / 4) for q in range(4)} | {"share_end": (0.9, 1.0)}
    metrics = {"success_training": outcomes.count("reached") / len(outcomes) if outcomes else None}
    for name, (begin, end) in parts.items():
        inside = (ends > begin) & (ends <= end)
        if config.agent.assisted and any(inside):
            metrics[name] = float(driven[inside].sum() / steps[inside].sum())
    return metrics


def _test_metrics(path: Path) -> dict[str, float | None]:
    tested = json.loads(path.read_text(encoding="utf-8"))
    parts = (("success", "last"), ("collision", "last"), ("success", "best"))
    return {f"{kind}_{checkpoint}": tested[checkpoint][f"{kind}_rate"]["value"] for kind, checkpoint in parts}


def _validation_metrics(rows: Sequence[dict[str, str]]) -> dict[str, float | None]:
    rates = [float(row["success_rate"]) for row in rows]
    if not rates:
        return {}
    last, best = (float(np.mean(five[-VALIDATIONS_COUNTED:])) for five in (rates, sorted(rates)))
    return {"last_five": last, "best_five": best, "swing": best - last}


def _switch_preference(path: Path, config: TrainConfig) -> float | None:
    """Unlike the controller's share, the schedule that takes the controller away does not touch it."""
    q = read_columns(path, ("q_policy", "q_controller"))
    q_policy, q_controller = (q[name][round(0.9 * config.total_steps) :] for name in ("q_policy", "q_controller"))
    is_known = ~np.isnan(q_policy) & ~np.isnan(q_controller)
    return float(np.mean(q_controller[is_known] > q_policy[is_known])) if is_known.any() else None
