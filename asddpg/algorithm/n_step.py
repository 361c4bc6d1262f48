"""n-step returns: a transition that reaches n steps ahead (Watkins, 1989; Sutton and Barto, chapter 7)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from asddpg.algorithm.replay import Transitions
from asddpg.episodes.batch_steps import BoolArray, FloatArray, IntArray


class NStepReturns:
    """Joins each step of a robot with those that follow it: rewards summed with discount, x' from n steps on.

    At an end, or where an episode is broken off, what is left is shorter. The actions between are those that were
    driven, by either driver: nothing corrects for it (Hessel et al., 2018, do the same).
    """

    def __init__(self, n: int, gamma: float, robots: int = 1) -> None:
        """Join `n` steps of each robot, each discounted by `gamma`."""
        self._n, self._gamma = n, gamma
        self._recent: list[Transitions] = []  # of all robots, the newest first, n at most
        self._open = np.zeros(robots, np.int64)  # of the recent ones, how many belong to a robot's present episode

    def begin_episodes(self, robots: IntArray) -> None:
        """Forget episodes that were broken off from outside: what followed their last steps is not known."""
        self._open[robots] = 0

    def add(self, steps: Transitions, is_last: BoolArray) -> list[Transitions]:
        """Add a step of each robot, the last where its episode ends or its time is up.

        Returns:
            The transitions that it completes, the oldest first.
        """
        self._recent = [steps, *self._recent[: self._n - 1]]
        self._open = np.minimum(self._open + 1, self._n)
        reward, switch_reward = np.zeros_like(steps.reward), np.zeros_like(steps.reward)
        completed = []
        for ahead, first in enumerate(self._recent):
            reward = first.reward + self._gamma * reward
            switch_reward = first.switch_reward + self._gamma * switch_reward
            done = (self._open > ahead) & (is_last | (ahead == self._n - 1))
            if done.any():
                completed.append(self._joined(first, ahead, (reward, switch_reward), done))
        self._open[is_last] = 0
        return completed[::-1]

    def _joined(
        self, first: Transitions, ahead: int, rewards: tuple[FloatArray, FloatArray], robots: BoolArray
    ) -> Transitions:
        last = self._recent[0]
        joined = first._replace(
            reward=rewards[0],
            switch_reward=rewards[1],
            discount=self._gamma**ahead * last.discount,
            next_observation=last.next_observation,
        )
        return joined.of(robots)

    def state(self) -> dict[str, Any]:
        """The recent steps, and how many of them each robot's return still waits for."""
        return {"recent": [steps._asdict() for steps in self._recent], "open": self._open.copy()}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore what state() returned.

        Raises:
            ValueError: it is of another number of robots.
        """
        if len(state["open"]) != len(self._open):
            raise ValueError(f"{len(self._open)} robots cannot take the returns of {len(state['open'])}")
        self._recent = [Transitions(**each) for each in state["recent"]]
        self._open = state["open"].copy()
