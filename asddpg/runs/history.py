"""The episode in progress, remembered and driven again: how a training is resumed in the middle of one.

A simulation that is driven again with the same actions from the same beginning comes to the same state, to the last
bit. So a checkpoint holds no state of the simulator: the steps are made again, and the environment and everybody who
watches come to where they were. Only the agent is not asked for them; it has a state of its own.
"""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, SupportsFloat

from asddpg.episodes.protocols import Agent, Decision, Driver, Episode, Observation, Step


class Remembered(NamedTuple):
    """A step that was made."""

    decision: Decision
    learned: Mapping[str, SupportsFloat]


class History:
    """Watches, and remembers the steps of the episode in progress."""

    def __init__(self) -> None:
        self._steps: list[Remembered] = []

    def __len__(self) -> int:
        return len(self._steps)

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Forget the last one."""
        self._steps = []

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Remember a step."""
        self._steps.append(Remembered(step.decision, learned))

    def end_episode(self, episode: Episode) -> None:
        """It is over."""
        self._steps = []

    def state(self) -> list[dict[str, Any]]:
        """The steps as plain values."""
        names = Decision.__slots__
        return [
            {**{name: getattr(decision, name) for name in names}, "learned": _numbers(learned)}
            for decision, learned in self._steps
        ]


def remembered(state: Sequence[Mapping[str, Any]]) -> list[Remembered]:
    """The steps in what History.state() gave."""
    steps = []
    for each in state:
        values = dict(each)
        learned, driver = values.pop("learned"), Driver(values.pop("driver"))
        steps.append(Remembered(Decision(driver=driver, **values), learned))
    return steps


def _numbers(learned: Mapping[str, SupportsFloat]) -> dict[str, float]:
    return {name: float(value) for name, value in learned.items()}


class Redriven:
    """Makes remembered steps again, then leaves the driving to the agent, whose state is that after them."""

    def __init__(self, agent: Agent, steps: Sequence[Remembered], caught_up: Callable[[], None]) -> None:
        """Begin an episode with steps; `caught_up` is called when the last has been made."""
        self._agent, self._steps, self._caught_up = agent, deque(steps), caught_up

    @property
    def num_left(self) -> int:
        """Steps still to be made again."""
        return len(self._steps)

    def begin_episode(self) -> None:
        """The agent has begun it long since, if there are steps."""
        if not self._steps:
            self._agent.begin_episode()

    def decide(self, observation: Observation) -> Decision:
        """As it was decided, as long as there is something to remember."""
        return self._steps[0].decision if self._steps else self._agent.decide(observation)

    def learn(self, step: Step) -> Mapping[str, SupportsFloat]:
        """What was learned from it."""
        if not self._steps:
            return self._agent.learn(step)
        learned = self._steps.popleft().learned
        if not self._steps:
            self._caught_up()
        return learned
