"""The one episode loop: training, evaluation and play all drive through it."""

from collections.abc import Mapping, Sequence
from typing import Any, SupportsFloat

from asddpg.episodes.episode_stats import EpisodeStats
from asddpg.episodes.protocols import Agent, Environment, Episode, Observation, Observer, Step


def run_episode(
    environment: Environment,
    agent: Agent,
    observers: Sequence[Observer] = (),
    options: dict[str, Any] | None = None,
    max_steps: int | None = None,
) -> Episode:
    """Drive one episode to its end.

    Args:
        environment: where to drive.
        agent: the driver, which may learn.
        observers: notified of the beginning, of each step and of the end.
        options: of the environment's reset, such as start and goal.
        max_steps: after so many steps the episode is cut.
    """
    episode = EpisodeInProgress(environment, agent, observers)
    episode.begin(options)
    while not episode.is_over and (max_steps is None or episode.steps < max_steps):
        episode.step()
    return episode.end()


class EpisodeInProgress:
    """An episode between two of its steps.

    Attributes:
        observation: the present one.
        is_over: whether the environment has ended it.
    """

    def __init__(self, environment: Environment, agent: Agent, observers: Sequence[Observer]) -> None:
        self._environment, self._agent, self._observers = environment, agent, observers
        self._outcome, self.is_over = "cut", False

    @property
    def steps(self) -> int:
        """Steps made so far."""
        return self._stats.steps

    def begin(self, options: dict[str, Any] | None = None) -> None:
        """Reset the environment, with these options, and begin."""
        self.observation, info = self._environment.reset(options=options)
        self._agent.begin_episode()
        for observer in self._observers:
            observer.begin_episode(self.observation, info)
        self._stats = EpisodeStats(info)

    def step(self) -> tuple[Step, Mapping[str, SupportsFloat]]:
        """Decide, step, learn, notify; returns the step and the metrics of what was learned from it."""
        decision = self._agent.decide(self.observation)
        next_observation, reward, terminated, truncated, info = self._environment.step(decision.action)
        step = Step(self.observation, decision, reward, next_observation, terminated, truncated, info)
        learned = self._agent.learn(step)
        self._stats.add(step)
        for observer in self._observers:
            observer.step(step, learned)
        self.observation = next_observation
        if terminated or truncated:
            self._outcome = info.get("outcome", "ended" if terminated else "timeout")
            self.is_over = True
        return step, learned

    def end(self) -> Episode:
        """Notify of the end; an episode that the environment has not ended is cut."""
        episode = self._stats.episode(self._outcome)
        for observer in self._observers:
            observer.end_episode(episode)
        return episode

    # Saving -------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """What the loop itself holds; environment, agent and observers have states of their own."""
        return self._stats.state()

    def resume(self, state: Mapping[str, Any], observation: Observation, info: Mapping[str, Any]) -> None:
        """Go on in mid-episode, with observation and info of the present instant; no observer is notified."""
        self.observation = observation
        self._stats = EpisodeStats(info)
        self._stats.load_state(state)
