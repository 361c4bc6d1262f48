"""Figures of episodes: outcomes, actions, and Q against the return that followed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from asddpg.config import TaskConfig
from asddpg.episodes.intervals import Estimate, rate
from tools.diagnosis.returns import FloatArray, Tail, discounted_returns
from tools.diagnosis.rollouts import Rollout

STILL_V = 0.02  # m/s above the least speed; slower than this the robot stands, as far as the task lets it
STILL_OMEGA = 0.05  # rad/s
CIRCLING_V = 0.05  # m/s above the least speed; from 0 and at full turn rate this is a circle of 5 cm
NOWHERE, NOWHERE_TIME = 0.3, 5.0  # m, s; who is no farther away after that time got nowhere
AT_BOUND = 0.01  # share of an action's range; nearer to a bound than this it is saturated
BINS = 10  # of Q, with as many states in each


@dataclass(frozen=True)
class End:
    """Where and how an episode ended, and how far from its goal; metres, world frame."""

    outcome: str
    x: float
    y: float
    distance: float


def _end(rollout: Rollout) -> End:
    x, y = rollout.places[-1].tolist()
    return End(rollout.outcome, round(x, 3), round(y, 3), round(math.dist((x, y), rollout.goal), 3))


@dataclass(frozen=True)
class DriveMetrics:
    """What a driver did; rates of episodes with 95 % Wilson intervals, shares of steps.

    Attributes:
        saturated_v: v at its largest or smallest.
        saturated_omega: ω at its largest or smallest.
        standing: neither driving (v less than 0.02 m/s above the task's least) nor turning (|ω| below 0.05 rad/s).
        circling: hardly driving (v less than 0.05 m/s above the least) at full turn rate.
        nowhere: less than 0.3 m away after the next 5 s, in whatever way; None where no episode is that long.
    """

    episodes: int
    success_rate: Estimate
    collision_rate: Estimate
    timeout_rate: Estimate
    mean_steps: float
    controller_share: float
    saturated_v: float
    saturated_omega: float
    standing: float
    circling: float
    nowhere: float | None
    ends: list[End]


def drive_metrics(rollouts: Sequence[Rollout], task: TaskConfig) -> DriveMetrics:
    """Outcomes and actions of episodes."""
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
        nowhere=_nowhere(rollouts, round(NOWHERE_TIME / task.control_timestep)),
        ends=[_end(rollout) for rollout in rollouts],
    )


def _nowhere(rollouts: Sequence[Rollout], steps: int) -> float | None:
    """Share of the steps after which, so many steps on, the robot is less than NOWHERE away."""
    offsets = np.concatenate([r.places[steps:] - r.places[: max(len(r.places) - steps, 0)] for r in rollouts])
    return float((np.hypot(*offsets.T) < NOWHERE).mean()) if len(offsets) else None


def _saturated(values: FloatArray, low: float, high: float) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    margin = AT_BOUND * (high - low)
    return (values <= low + margin) | (values >= high - margin)


@dataclass(frozen=True)
class QBin:
    """States of about the same Q: its mean, and of the return that followed mean, 10 % and 90 % quantile."""

    q: float
    mean: float
    low: float
    high: float
    states: int


@dataclass(frozen=True)
class QCalibration:
    """Q against the return that followed; None where no state counts.

    Attributes:
        states: that count.
        left_out: too near the time limit for their return to be known.
        mean_q: of the states that count.
        mean_return: the middle of the return's bounds.
        bias: mean of Q less mean of the return.
        bias_low: the bias if the best followed every time limit.
        bias_high: the bias if the worst did.
        bins: by Q.
    """

    states: int
    left_out: int
    mean_q: float | None
    mean_return: float | None
    bias: float | None
    bias_low: float | None
    bias_high: float | None
    bins: list[QBin]


def q_calibration(q: FloatArray, rollouts: Sequence[Rollout], gamma: float, tail: Tail) -> QCalibration:
    """Hold Q of all states of some episodes, one episode after the other, against what followed."""
    parts = [discounted_returns(r.rewards, gamma, r.outcome != "timeout", tail) for r in rollouts]
    low, high, counts = (np.concatenate(part) for part in zip(*parts, strict=True))
    low, high, q, states = low[counts], high[counts], q[counts], int(counts.sum())
    if not states:
        return QCalibration(0, len(counts), None, None, None, None, None, [])
    middle = (low + high) / 2
    mean_q = float(q.mean())
    return QCalibration(
        states=states,
        left_out=len(counts) - states,
        mean_q=mean_q,
        mean_return=float(middle.mean()),
        bias=mean_q - float(middle.mean()),
        bias_low=mean_q - float(high.mean()),
        bias_high=mean_q - float(low.mean()),
        bins=_bins(q, middle),
    )


def _bins(q: FloatArray, returns: FloatArray) -> list[QBin]:
    parts = [part for part in np.array_split(np.argsort(q, kind="stable"), BINS) if len(part)]
    return [
        QBin(
            q=float(q[part].mean()),
            mean=float(returns[part].mean()),
            low=float(np.quantile(returns[part], 0.1)),
            high=float(np.quantile(returns[part], 0.9)),
            states=len(part),
        )
        for part in parts
    ]
