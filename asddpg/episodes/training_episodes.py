"""The episodes of a training, driven step by step; their state can be saved after any step."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, Protocol

from asddpg.episodes.finite_check import check_finite, check_step
from asddpg.episodes.loop import EpisodeInProgress
from asddpg.episodes.protocols import Agent, Environment, Observer, Stateful
from asddpg.episodes.random_streams import stream


class LearningAgent(Agent, Stateful, Protocol):
    """An agent that learns and whose state can be saved."""


class TrainingEpisodes:
    """Drives and learns, episode after episode.

    Attributes:
        num_finished: episodes that are over.
        observers: notified of the episodes; to be filled before the first step.
        restored: observation and info of the instant at which a resumed episode goes on.
    """

    def __init__(self, environment: Environment, stateful: Stateful, agent: LearningAgent, seed: int) -> None:
        """Begin a training with the seed of the run; `stateful` is the same environment below its wrappers."""
        environment.reset(seed=int(stream(seed, "start_goal").integers(2**31)))
        self._environment, self._stateful, self._agent = environment, stateful, agent
        self._episode: EpisodeInProgress | None = None
        self.observers: list[Observer] = []
        self._finished_steps = self.num_finished = 0

    @property
    def step(self) -> int:
        """Training steps made so far."""
        return self._finished_steps + (self._episode.stats.steps if self._episode else 0)

    @property
    def is_in_episode(self) -> bool:
        """Whether an episode is in progress."""
        return self._episode is not None

    def drive_step(self, total_steps: int) -> None:
        """Make one training step; it begins an episode where none is in progress, and ends one that is over.

        Args:
            total_steps: of the training; an episode in progress then is cut.

        Raises:
            NotFiniteError: a number of the step is NaN or infinite.
        """
        if self._episode is None:
            episode = EpisodeInProgress(self._environment, self._agent, self.observers)
            episode.begin()
            check_finite("the observation", episode.observation)
            self._episode = episode
        check_step(*self._episode.step())
        if self._episode.is_over or self.step >= total_steps:
            self._finished_steps += self._episode.end().steps
            self._episode = None
            self.num_finished += 1

    def state(self) -> dict[str, Any]:
        """All that the next steps depend on, but for the observers'."""
        return {
            "finished_steps": self._finished_steps,
            "finished_episodes": self.num_finished,
            "episode": asdict(self._episode.stats) if self._episode else None,
            "environment": self._stateful.state(),
            "agent": self._agent.state(),
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore what state() returned.

        Raises:
            LookupError, RuntimeError, TypeError, ValueError, AttributeError: it is of another agent or environment.
        """
        self._finished_steps, self.num_finished = state["finished_steps"], state["finished_episodes"]
        self.restored = self._stateful.load_state(state["environment"])
        self._agent.load_state(state["agent"])
        if state["episode"] is not None:
            self._episode = EpisodeInProgress(self._environment, self._agent, self.observers)
            self._episode.resume(state["episode"], *self.restored)
