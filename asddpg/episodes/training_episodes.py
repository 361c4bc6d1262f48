"""The episodes of a training, all robots driven side by side, step by step; their state can be saved after any step."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, SupportsFloat

import numpy as np

from asddpg.episodes.batch_steps import BoolArray, Decisions, Float32Array, FloatArray, Infos, IntArray, Steps
from asddpg.episodes.episode_sums import EpisodeSums, outcome_of
from asddpg.episodes.finite_check import check_finite, check_learned, check_steps
from asddpg.episodes.protocols import Episode, Stateful
from asddpg.episodes.random_streams import stream

Learned = Sequence[Mapping[str, SupportsFloat]]  # metrics by name, of each update


class LearningAgent(Stateful, Protocol):
    """An agent that drives robots and learns from all of them, and whose state can be saved."""

    def begin_episodes(self, robots: IntArray, observations: Float32Array) -> None:
        """Reset what belongs to one episode, for robots of these numbers, with their first observations."""

    def decide(self, observations: Float32Array) -> Decisions:
        """Choose the next action of every robot."""

    def store(self, steps: Steps) -> None:
        """Keep a step of every robot."""

    def learn(self) -> Learned:
        """Make the updates that are due for a step of every robot; returns their metrics."""


class RobotsEnvironment(Stateful, Protocol):
    """The part of NavigationVectorEnv that a training uses."""

    num_envs: int

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32Array, dict[str, Any]]:
        """Begin episodes, of the robots in options["reset_mask"] if it is given."""

    def begin_step(self, actions: Any) -> None:
        """Begin a control step of every robot, in threads."""

    def finish_step(self) -> tuple[Float32Array, FloatArray, BoolArray, BoolArray, dict[str, Any]]:
        """Wait for it: observations, rewards, terminated, truncated, infos."""


class TrainingObserver(Protocol):
    """Is notified of a training's episodes; changes nothing. A class derived from it defines the methods it needs."""

    def begin_episodes(self, robots: IntArray, numbers: IntArray, observations: Float32Array, infos: Infos) -> None:
        """Robots begin the episodes of these numbers, (k,); observations and infos have a row for every robot."""
        return

    def step(self, steps: Steps, learned: Learned) -> None:
        """Every robot made a step."""
        return

    def end_episode(self, robot: int, number: int, episode: Episode) -> None:
        """The episode of a robot is over."""
        return


class TrainingEpisodes:
    """Drives and learns, episode after episode.

    With several robots the agent learns while they drive, from the steps before: one step late, on another core. With
    one it learns after its step, as Algorithm 1 has it.

    Attributes:
        step: training steps made so far, of all robots together.
        numbers: of each robot's newest episode, (robots,), counted over all robots in the order of their beginnings.
        observations, infos: of the present instant.
        observers: notified of the episodes; to be filled before the first step.
    """

    def __init__(self, environment: RobotsEnvironment, agent: LearningAgent, seed: int) -> None:
        """Begin a training with the seed of the run."""
        robots = environment.num_envs
        self._environment, self._agent = environment, agent
        self.observers: list[TrainingObserver] = []
        self.step = 0
        self.numbers: IntArray = np.zeros(robots, np.int64)
        self._in_progress = np.zeros(robots, np.bool_)
        self._sums = EpisodeSums(robots)
        self.infos: Infos
        self.observations, self.infos = environment.reset(seed=int(stream(seed, "start_goal").integers(2**31)))

    @property
    def in_progress(self) -> BoolArray:
        """Whether each robot is within an episode, (robots,)."""
        return self._in_progress

    def drive_step(self, total_steps: int) -> None:
        """Make one step with every robot; those without an episode begin one, those whose episode is over end it.

        Args:
            total_steps: of the training; episodes in progress then are cut.

        Raises:
            NotFiniteError: a number of the step is NaN or infinite.
        """
        if not self._in_progress.all():
            self._begin_episodes()
        decisions = self._agent.decide(self.observations)
        check_finite("the action", decisions.actions)
        self._environment.begin_step(decisions.actions)
        is_beside = len(self.numbers) > 1
        try:
            learned = self._agent.learn() if is_beside else ()
        finally:
            found = self._environment.finish_step()
        self.step += len(self.numbers)
        steps = Steps(self.observations, decisions, found[1], found[0], *found[2:])
        check_steps(steps)
        self._agent.store(steps)
        if not is_beside:
            learned = self._agent.learn()
        self._count(steps, learned, total_steps)

    def _begin_episodes(self) -> None:
        idle = ~self._in_progress
        robots = np.flatnonzero(idle)
        self.observations, self.infos = self._environment.reset(options={"reset_mask": idle})
        check_finite("the observation", self.observations)
        self._agent.begin_episodes(robots, self.observations[robots])
        self.numbers[robots] = self.numbers.max() + 1 + np.arange(len(robots))
        self._sums.reset(robots)
        self._in_progress[:] = True
        for observer in self.observers:
            observer.begin_episodes(robots, self.numbers[robots], self.observations, self.infos)

    def _count(self, steps: Steps, learned: Learned, total_steps: int) -> None:
        """Count and show a step, and end the episodes that are over."""
        check_learned(learned)
        self._sums.add(steps, self.infos)
        self.observations, self.infos = steps.next_observations, steps.infos
        for observer in self.observers:
            observer.step(steps, learned)
        over = steps.terminated | steps.truncated
        ending = over | (self.step >= total_steps)
        for robot in np.flatnonzero(ending).tolist():
            episode = self._sums.episode(robot, outcome_of(steps, robot) if over[robot] else "cut")
            for observer in self.observers:
                observer.end_episode(robot, int(self.numbers[robot]), episode)
        self._in_progress &= ~ending

    def state(self) -> dict[str, Any]:
        """All that the next steps depend on, but for the observers'."""
        return {
            "step": self.step,
            "numbers": self.numbers.copy(),
            "in_progress": self._in_progress.copy(),
            "sums": self._sums.state(),
            "environment": self._environment.state(),
            "agent": self._agent.state(),
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore what state() returned.

        Raises:
            LookupError, RuntimeError, TypeError, ValueError, AttributeError: it is of another agent or environment.
        """
        if len(state["numbers"]) != len(self.numbers):
            raise ValueError(f"it is of {len(state['numbers'])} robots, and there are {len(self.numbers)}")
        self.observations, self.infos = self._environment.load_state(state["environment"])
        self._agent.load_state(state["agent"])
        self.step, self.numbers = state["step"], state["numbers"].copy()
        self._in_progress = state["in_progress"].copy()
        self._sums.load_state(state["sums"])
