"""Schedules over a training: of the controller's withdrawal, the learning rates and the weight of smoothness."""

from typing import TYPE_CHECKING, Any

import numpy as np

from asddpg.episodes.batch_steps import IntArray

if TYPE_CHECKING:
    from asddpg.config import WithdrawalConfig


class Withdrawal:
    """Decides when the controller may drive at all; where it may, the switch decides.

    The share of episodes that the actor drives alone rises linearly from `first_share` to `last_share` between two
    steps of training.

    Attributes:
        is_alone: (robots,) whether a robot's actor drives alone now.
    """

    def __init__(self, config: "WithdrawalConfig", total_steps: int, rng: np.random.Generator, robots: int = 1) -> None:
        """Set the schedule for a training of `total_steps` steps of all robots together."""
        self._begin, self._end = config.begin * total_steps, config.end * total_steps
        self._first, self._last = config.first_share, config.last_share
        self._stretch_steps = config.stretch_steps
        self._rng = rng
        self._steps = 0
        self._steps_since_draw = np.zeros(robots, np.int64)
        self.is_alone = np.zeros(robots, np.bool_)

    @property
    def share(self) -> float:
        """Present share of episodes that the actor drives alone."""
        if self._steps >= self._end:
            return self._last
        passed = max(0.0, self._steps - self._begin) / max(self._end - self._begin, 1.0)
        return self._first + passed * (self._last - self._first)

    def begin_episodes(self, robots: IntArray) -> None:
        """Draw whether the controller may drive in the episodes of these robots."""
        self.is_alone[robots] = self._rng.random(len(robots)) < self.share
        self._steps_since_draw[robots] = 0

    def advance(self) -> None:
        """One step of each robot has passed."""
        self._steps += len(self.is_alone)
        self._steps_since_draw += 1
        if self._stretch_steps:
            due = np.flatnonzero(self._steps_since_draw >= self._stretch_steps)
            if len(due):
                self.begin_episodes(due)

    def state(self) -> dict[str, Any]:
        """Position in the schedule, whether the controller may drive, and the random stream."""
        return {
            "steps": self._steps,
            "steps_since_draw": self._steps_since_draw.copy(),
            "is_alone": self.is_alone.copy(),
            "rng": self._rng.bit_generator.state,
        }

    def load_state(self, state: dict[str, Any]) -> None:
        """Restore what state() returned."""
        self._steps, self._steps_since_draw[:] = state["steps"], state["steps_since_draw"]
        self.is_alone[:] = state["is_alone"]
        self._rng.bit_generator.state = state["rng"]


def learning_rate_scale(step: int, total_steps: int, share: float) -> float:
    """Scale of the learning rates: 1, then linearly to 0 over the last `share` (0 to 1; 0 for never) of training."""
    if not share:
        return 1.0
    return min(1.0, max(0.0, 1.0 - step / total_steps) / share)


SMOOTHNESS_GROWS = (0.2, 0.6)  # share of training at which its weight begins to grow, and is full


def smoothness_scale(steps: int, total_steps: int) -> float:
    """Factor on the smoothness's weight after some steps: at full weight a policy learns nothing in the beginning."""
    begin, end = SMOOTHNESS_GROWS
    return min(max((steps / total_steps - begin) / (end - begin), 0.0), 1.0)
