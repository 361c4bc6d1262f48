"""Metrics of episodes: outcomes, actions, and Q against the return that followed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from asddpg.config import TaskConfig
from asddpg.episodes.intervals import Estimate, rate
from tasks.physics import FloatArray
from tools.diagnosis.returns import Tail, discounted_returns
from tools.diagnosis.rollouts import Rollout

STILL_V, STILL_OMEGA = 0.02, 0.05  # m/s above the least speed, rad/s; a slower robot stands still
CIRCLING_V = 0.05  # m/s above the least speed; from 0 and at full turn rate this is a circle of 5 cm
STUCK_DISTANCE, STUCK_TIME = 0.3, 5.0  # m, s; a robot no farther away after that time is stuck
AT_BOUND = 0.01  # share of an action's range; nearer to a bound an action is saturated
BINS = 10  # of Q, with as many states in each


@dataclass(frozen=True)
class End:
    """Where and how an episode ended, and how far from its goal; metres, world frame."""

    outcome: str
    x: float
    y: float
    distance: float


@dataclass(frozen=True)
class DriveMetrics:
    """Outcomes of a driver as rates with 95 % Wilson intervals, its actions as shares of the steps."""

    episodes: int
    success_rate: Estimate
    collision_rate: Estimate
    timeout_rate: Estimate
    mean_steps: float
    controller_share: float
    saturated_v: float  # v at its largest or smallest
    saturated_omega: float  # ω at its largest or smallest
    standing: float  # neither driving (v less than STILL_V above the task's least) nor turning
    circling: float  # hardly driving (v less than CIRCLING_V above the least) at full turn rate
    stuck: float | None  # less than 0.3 m away 5 s later; None where no episode is that long
    ends: list[End]


def drive_metrics(rollouts: Sequence[Rollout], task: TaskConfig) -> DriveMetrics:
    """Metrics of episodes."""
    outcomes = [rollout.outcome for rollout in rollouts]
    v, omega = np.concatenate([rollout.actions for rollout in rollouts]).T
    by_controller = np.concatenate([rollout.by_controller for rollout in rollouts])
    least, fastest_turn = task.min_linear_velocity, task.max_angular_velocity
    turns = _saturated(omega, -fastest_turn, fastest_turn)
    return DriveMetrics(
        episodes=len(rollouts),
        success_rate=rate(outcomes.count("reached"), len(outcomes)),
        collision_rate=rate(outcomes.count("crashed"), len(outcomes)),
        timeout_rate=rate(outcomes.count("timeout"), len(outcomes)),
        mean_steps=len(v) / len(rollouts),
        controller_share=float(by_controller.mean()),
        saturated_v=float(_saturated(v, least, task.max_linear_velocity).mean()),
        saturated_omega=float(turns.mean()),
        standing=float(((v < least + STILL_V) & (np.abs(omega) < STILL_OMEGA)).mean()),
        circling=float(((v < least + CIRCLING_V) & turns).mean()),
        stuck=_stuck_share(rollouts, round(STUCK_TIME / task.control_timestep)),
        ends=[_end(rollout) for rollout in rollouts],
    )


def _end(rollout: Rollout) -> End:
    x, y = rollout.places[-1].tolist()
    return End(rollout.outcome, round(x, 3), round(y, 3), round(math.dist((x, y), rollout.goal), 3))


def _stuck_share(rollouts: Sequence[Rollout], steps: int) -> float | None:
    """Share of the steps from which the robot is less than STUCK_DISTANCE away `steps` later."""
    offsets = np.concatenate([r.places[steps:] - r.places[: max(len(r.places) - steps, 0)] for r in rollouts])
    return float((np.hypot(*offsets.T) < STUCK_DISTANCE).mean()) if len(offsets) else None


def _saturated(values: FloatArray, low: float, high: float) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    margin = AT_BOUND * (high - low)
    return (values <= low + margin) | (values >= high - margin)


@dataclass(frozen=True)
class QBin:
    """A tenth of the states by Q: mean of Q; mean, 10 % and 90 % quantile of the return."""

    q: float
    mean: float
    low: float
    high: float
    states: int


@dataclass(frozen=True)
class QCalibration:
    """Q against the return that followed; None where no state counts."""

    states: int  # that count
    excluded: int  # too near the time limit for their return to be known
    mean_q: float | None = None  # over the states that count
    mean_return: float | None = None  # over the same states, middle of the bounds
    bias: float | None = None  # mean of Q minus mean of the return
    bias_low: float | None = None  # if the best followed every time limit
    bias_high: float | None = None  # if the worst did
    bins: list[QBin] = field(default_factory=list)  # groups of states by Q


def q_calibration(q: FloatArray, rollouts: Sequence[Rollout], gamma: float, tail: Tail) -> QCalibration:
    """Compare Q (states,) of all states of episodes, one episode after the other, with the return that followed."""
    parts = [discounted_returns(r.rewards, gamma, r.outcome != "timeout", tail) for r in rollouts]
    low, high, counts = (np.concatenate(part) for part in zip(*parts, strict=True))
    low, high, q, states = low[counts], high[counts], q[counts], int(counts.sum())
    if not states:
        return QCalibration(0, len(counts))
    middle = (low + high) / 2
    mean_q = float(q.mean())
    return QCalibration(
        states=states,
        excluded=len(counts) - states,
        mean_q=mean_q,
        mean_return=float(middle.mean()),
        bias=mean_q - float(middle.mean()),
        bias_low=mean_q - float(high.mean()),
        bias_high=mean_q - float(low.mean()),
        bins=[_bin(q[part], middle[part]) for part in np.array_split(np.argsort(q, kind="stable"), min(BINS, states))],
    )


def _bin(q: FloatArray, returns: FloatArray) -> QBin:
    low, high = np.quantile(returns, (0.1, 0.9)).tolist()
    return QBin(float(q.mean()), float(returns.mean()), low, high, len(q))
