"""The episodes of a training, driven step by step; their state can be saved after any step."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from asddpg.episodes.finite_check import check_observation, check_step
from asddpg.episodes.loop import EpisodeInProgress
from asddpg.episodes.protocols import Agent, Environment, Observation, Observer
from asddpg.episodes.random_streams import stream


class StatefulEnvironment(Protocol):
    """The part of NavigationEnv that saves and restores."""

    def state(self) -> dict[str, Any]:
        """All that its next steps depend on."""

    def load_state(self, state: Mapping[str, Any]) -> tuple[Observation, dict[str, Any]]:
        """Restore what state() returned; returns observation and info of that instant."""


class LearningAgent(Agent, Protocol):
    """An agent that learns and whose state can be saved."""

    def state(self) -> dict[str, Any]:
        """All that its next steps depend on."""

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore what state() returned."""


class TrainingEpisodes:
    """Drives and learns, episode after episode.

    Attributes:
        num_finished: episodes that are over.
        observers: notified of the episodes; to be set before the first step.
        restored: observation and info of the instant at which a resumed episode goes on.
    """

    def __init__(
        self, environment: Environment, stateful: StatefulEnvironment, agent: LearningAgent, seed: int
    ) -> None:
        """Begin a training.

        Args:
            environment: where to drive.
            stateful: the same environment below its wrappers.
            agent: the driver, which learns.
            seed: of the run.
        """
        environment.reset(seed=int(stream(seed, "start_goal").integers(2**31)))
        self._environment, self._stateful, self._agent = environment, stateful, agent
        self._episode: EpisodeInProgress | None = None
        self._to_resume: Mapping[str, Any] | None = None  # the loop's state of an episode in progress
        self.observers: Sequence[Observer] = ()
        self._finished_steps = self.num_finished = 0

    @property
    def step(self) -> int:
        """Training steps made so far."""
        if self._to_resume is not None:
            return self._finished_steps + int(self._to_resume["steps"])
        return self._finished_steps + (self._episode.steps if self._episode else 0)

    @property
    def is_in_episode(self) -> bool:
        """Whether an episode is in progress."""
        return self._episode is not None or self._to_resume is not None

    def drive_step(self, total_steps: int) -> None:
        """Make one training step; it begins an episode where none is in progress, and ends one that is over.

        Args:
            total_steps: of the training; an episode in progress then is cut.

        Raises:
            NotFiniteError: a number of the step is NaN or infinite.
        """
        if self._episode is None:
            self._episode = self._begin() if self._to_resume is None else self._resume(self._to_resume)
        check_step(*self._episode.step())
        if self._episode.is_over or self.step >= total_steps:
            episode = self._episode.end()
            self._episode = None
            self._finished_steps += episode.steps
            self.num_finished += 1

    def _begin(self) -> EpisodeInProgress:
        episode = EpisodeInProgress(self._environment, self._agent, self.observers)
        episode.begin()
        check_observation(episode.observation)
        return episode

    def _resume(self, state: Mapping[str, Any]) -> EpisodeInProgress:
        episode = EpisodeInProgress(self._environment, self._agent, self.observers)
        episode.resume(state, *self.restored)
        self._to_resume = None
        return episode

    def state(self) -> dict[str, Any]:
        """All that the next steps depend on, but for the observers'."""
        return {
            "finished_steps": self._finished_steps,
            "finished_episodes": self.num_finished,
            "episode": self._episode.state() if self._episode else self._to_resume,
            "environment": self._stateful.state(),
            "agent": self._agent.state(),
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore what state() returned.

        Raises:
            LookupError, RuntimeError, TypeError, ValueError, AttributeError: it is of another agent or environment.
        """
        self._finished_steps, self.num_finished = state["finished_steps"], state["finished_episodes"]
        self._to_resume = state["episode"]
        self.restored = self._stateful.load_state(state["environment"])
        self._agent.load_state(state["agent"])
