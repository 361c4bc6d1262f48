"""The discounted return that really follows each state of an episode, time limits treated as what they are: unknown.

An episode that the time limit broke off would have gone on. What followed its last step lies between the worst and the
best that the reward allows, and weighs γ^k after k steps: each state so gets the bounds of its return, and states too
near the limit for the bounds to say much are left out.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from asddpg.config import TrainConfig

FloatArray = npt.NDArray[np.float64]

LARGEST_UNKNOWN = 0.2  # weight up to which an unknown rest is borne; 0.99^160


class Tail(NamedTuple):
    """The worst and the best that may follow a time limit."""

    worst: float
    best: float


class Returns(NamedTuple):
    """Of each step of an episode, (steps,): the bounds of its return, equal after a true end, and whether to count."""

    low: FloatArray
    high: FloatArray
    counts: npt.NDArray[np.bool_]


def tail_of(config: TrainConfig) -> Tail:
    """What the reward of a run allows: a step's worst or best for ever, or an end at once."""
    reward, task = config.reward, config.task
    progress = reward.progress * task.max_linear_velocity * task.control_timestep
    for_ever = 1.0 / (1.0 - config.agent.gamma)
    worst_step = -progress - reward.time_penalty - config.agent.controller_price
    best_step = progress - reward.time_penalty
    return Tail(min(worst_step * for_ever, reward.crash), max(best_step * for_ever, reward.reach))


def discounted_returns(rewards: FloatArray, gamma: float, is_ended: bool, tail: Tail) -> Returns:
    """Σ γ^i r of what followed each step.

    Args:
        rewards: of an episode's steps, (steps,).
        gamma: γ.
        is_ended: whether the last step ended it; else the time limit did.
        tail: what may follow a time limit.
    """
    low, high = (0.0, 0.0) if is_ended else tail
    lows, highs = np.empty(len(rewards)), np.empty(len(rewards))
    for index in range(len(rewards) - 1, -1, -1):
        low, high = rewards[index] + gamma * low, rewards[index] + gamma * high
        lows[index], highs[index] = low, high
    unknown = gamma ** np.arange(len(rewards), 0, -1)
    return Returns(lows, highs, (unknown <= LARGEST_UNKNOWN) | is_ended)
