"""The discounted return that followed each state of an episode, with bounds where the time limit cut the episode.

An episode that the time limit truncated would have gone on. The return after its last step lies between the worst and
the best that the reward allows, and weighs γ^k for a state k steps earlier. Each state thus gets bounds of its return;
states too near the limit are excluded.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter

from asddpg.config import TrainConfig
from tasks.physics import FloatArray

MAX_UNKNOWN_WEIGHT = 0.2  # of the unknown rest of a return; 0.99^160


@dataclass(frozen=True)
class Tail:
    """The worst and the best return after a time limit."""

    worst: float
    best: float


class Returns(NamedTuple):
    """Bounds of the return of each step, equal after a true end, and whether the step counts; each (steps,)."""

    low: FloatArray
    high: FloatArray
    is_counted: npt.NDArray[np.bool_]


def tail_bounds(config: TrainConfig) -> Tail:
    """Bounds of the return that the reward allows: a step's worst or best reward for ever, or an end at once."""
    reward, task = config.reward, config.task
    progress = reward.progress * task.max_linear_velocity * task.control_timestep
    for_ever = 1.0 / (1.0 - config.agent.gamma)
    worst_step = -progress - reward.time_penalty - config.agent.controller_price
    best_step = progress - reward.time_penalty
    return Tail(min(worst_step * for_ever, reward.crash), max(best_step * for_ever, reward.reach))


def discounted_returns(rewards: FloatArray, gamma: float, is_ended: bool, tail: Tail) -> Returns:
    """Σ γ^i r from each step on, of the rewards (steps,) of an episode.

    It ended, or the time limit truncated it and a return within `tail` would have followed.
    """
    known = lfilter([1.0], [1.0, -gamma], rewards[::-1])[::-1]
    if is_ended:
        return Returns(known, known, np.ones(len(rewards), dtype=np.bool_))
    weights = gamma ** np.arange(len(rewards), 0, -1)  # of the return after the time limit
    return Returns(known + weights * tail.worst, known + weights * tail.best, weights <= MAX_UNKNOWN_WEIGHT)
