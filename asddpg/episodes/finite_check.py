"""The NaN guard: numbers gone wrong end a training in the step in which they appear."""

import math
from collections.abc import Mapping, Sequence
from typing import SupportsFloat

import numpy as np
import numpy.typing as npt

from asddpg.episodes.batch_steps import Steps

LOSSES = ("critic_loss", "switch_loss", "policy_loss")  # a TD error may be NaN: of a driver that no sample is of


class NotFiniteError(Exception):
    """A number of a training is NaN or infinite; the message says which. All checks of this module raise it."""


def check_finite(name: str, numbers: npt.NDArray[np.float32]) -> None:
    """See that an array, called by that name, is finite."""
    if not np.isfinite(numbers).all():
        raise NotFiniteError(f"{name} holds {numbers[~np.isfinite(numbers)][0]}")


def check_steps(steps: Steps) -> None:
    """See that the observations and rewards of a step are finite."""
    check_finite("the observation", steps.next_observations)
    if not np.isfinite(steps.rewards).all():
        raise NotFiniteError(f"the reward is {steps.rewards[~np.isfinite(steps.rewards)][0]}")


def check_learned(learned: Sequence[Mapping[str, SupportsFloat]]) -> None:
    """See that the losses of each update are finite."""
    for losses in learned:
        for name in LOSSES:
            if name in losses and not math.isfinite(value := float(losses[name])):
                raise NotFiniteError(f"{name} is {value}")


def check_weights(are_finite: Mapping[str, bool]) -> None:
    """See that the weights of each network, by its name, are finite."""
    for name, is_finite in are_finite.items():
        if not is_finite:
            raise NotFiniteError(f"a weight of {name} is not finite")
