"""The loop of one robot's episodes: evaluation and play drive through it."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from asddpg.episodes.protocols import Agent, Driver, Environment, Episode, Observer, Step


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
    while not episode.is_over and (max_steps is None or episode.stats.steps < max_steps):
        episode.step()
    return episode.end()


def count_step(episode: Episode, step: Step, previous_info: Mapping[str, Any]) -> None:
    """Add a step to an episode's sums; `previous_info` is that of the instant before it."""
    episode.steps += 1
    episode.total_reward += step.reward
    episode.controller_steps += step.decision.driver is Driver.CONTROLLER
    if "pose" in previous_info:
        episode.path_length += math.dist(previous_info["pose"][:2], step.info["pose"][:2])


class EpisodeInProgress:
    """An episode between two of its steps.

    Attributes:
        observation: the present one.
        stats: of the episode so far.
        is_over: whether the environment has ended it.
    """

    def __init__(self, environment: Environment, agent: Agent, observers: Sequence[Observer]) -> None:
        self._environment, self._agent, self._observers = environment, agent, observers
        self.stats, self.is_over = Episode(), False
        self._info: Mapping[str, Any] = {}

    def begin(self, options: dict[str, Any] | None = None) -> None:
        """Reset the environment, with these options, and begin."""
        self.observation, self._info = self._environment.reset(options=options)
        self._agent.begin_episode()
        for observer in self._observers:
            observer.begin_episode(self.observation, self._info)

    def step(self) -> None:
        """Decide, step, learn, notify."""
        decision = self._agent.decide(self.observation)
        next_observation, reward, terminated, truncated, info = self._environment.step(decision.action)
        step = Step(self.observation, decision, reward, next_observation, terminated, truncated, info)
        learned = self._agent.learn(step)
        count_step(self.stats, step, self._info)
        self._info = info
        for observer in self._observers:
            observer.step(step, learned)
        self.observation = next_observation
        if terminated or truncated:
            outcome = info.get("outcome", "running")
            self.stats.outcome = outcome if outcome != "running" else "ended" if terminated else "timeout"
            self.is_over = True

    def end(self) -> Episode:
        """Notify of the end; an episode that the environment has not ended is cut."""
        for observer in self._observers:
            observer.end_episode(self.stats)
        return self.stats
