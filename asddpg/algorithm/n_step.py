"""n-step returns: a transition that reaches n steps ahead (Watkins, 1989; Sutton and Barto, chapter 7)."""

from collections import deque
from typing import Any

from asddpg.algorithm.replay import Transition


class NStepReturns:
    """Joins each transition with those that follow it: rewards summed with discount, x' from n steps on.

    At an end, or where an episode is broken off, what is left is shorter. The actions between are those that were
    driven, by either driver: nothing corrects for it (Hessel et al., 2018, do the same).
    """

    def __init__(self, n: int, gamma: float) -> None:
        """Join `n` steps, each discounted by `gamma`."""
        self._n, self._gamma = n, gamma
        self._open: deque[Transition] = deque()

    def begin_episode(self) -> None:
        """Forget an episode that was broken off from outside: what followed its last steps is not known."""
        self._open.clear()

    def add(self, transition: Transition, is_last: bool) -> list[Transition]:
        """Add a step, the last where its episode ends or its time is up; returns the transitions that it completes."""
        self._open.append(transition)
        finished = []
        while self._open and (is_last or len(self._open) == self._n):
            finished.append(self._joined())
            self._open.popleft()
        return finished

    def state(self) -> list[dict[str, Any]]:
        """The steps whose return is not complete yet."""
        return [transition._asdict() for transition in self._open]

    def load_state(self, state: list[dict[str, Any]]) -> None:
        """Restore what state() returned."""
        self._open = deque(Transition(**each) for each in state)

    def _joined(self) -> Transition:
        reward = switch_reward = 0.0
        for transition in reversed(self._open):
            reward = transition.reward + self._gamma * reward
            switch_reward = transition.switch_reward + self._gamma * switch_reward
        first, last = self._open[0], self._open[-1]
        return first._replace(
            reward=reward,
            switch_reward=switch_reward,
            discount=self._gamma ** (len(self._open) - 1) * last.discount,
            next_observation=last.next_observation,
        )
