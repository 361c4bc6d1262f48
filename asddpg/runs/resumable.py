"""A training's episodes, whose state can be taken after any step and taken up by another process."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import gymnasium

from asddpg.algorithm.agent import AsDDPG
from asddpg.build import navigation_env
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Agent, Episode, Observer
from asddpg.episodes.random_streams import stream
from asddpg.errors import UserError
from asddpg.observers.finite_check import NotFiniteError
from asddpg.runs.history import History, Redriven, Remembered, remembered


class ResumableEpisodes:
    """Drives and learns, episode after episode.

    Attributes:
        steps: of the episodes that are over.
        episodes: that are over.
    """

    def __init__(self, environment: gymnasium.Env, agent: AsDDPG, seed: int, say: Callable[[str], None]) -> None:
        """Begin a training.

        Args:
            environment: where to drive, with a NavigationEnv at its core.
            agent: who drives and learns.
            seed: of the run.
            say: told if an episode that is driven again comes out otherwise.
        """
        environment.reset(seed=int(stream(seed, "start_goal").integers(2**31)))
        self._environment, self._agent, self._say = environment, agent, say
        self._core = navigation_env(environment)
        self._history = History()
        self._to_redrive: Sequence[Remembered] = ()
        self._digest: int | None = None
        self._randomness = self._core.random_state()  # as the episode in progress began
        self.steps = self.episodes = 0

    @property
    def step(self) -> int:
        """Training steps made so far."""
        return self.steps + len(self._history)

    def drive_episode(self, observers: Sequence[Observer], max_steps: int) -> Episode:
        """Drive the next episode, or the one in progress from its beginning, to its end or for `max_steps`."""
        self._randomness = self._core.random_state()
        redriven = Redriven(self._agent, self._to_redrive, self._compare)
        driver: Agent = redriven if self._to_redrive else self._agent
        episode = run_episode(self._environment, driver, [self._history, *observers], max_steps=max_steps)
        self._to_redrive = ()
        if redriven.num_left:
            self._tell_difference()
        self.steps += episode.steps
        self.episodes += 1
        return episode

    def check_weights(self) -> None:
        """See that the agent's weights are numbers.

        Raises:
            NotFiniteError: one is none.
        """
        for name, is_finite in self._agent.finite_weights().items():
            if not is_finite:
                raise NotFiniteError(f"a weight of {name} is not finite")

    def state(self) -> dict[str, Any]:
        """All that the steps to come depend on."""
        return {
            "steps": self.steps,
            "episodes": self.episodes,
            "randomness": self._randomness if len(self._history) else self._core.random_state(),
            "history": self._history.state(),
            "digest": self._core.physics.state_digest() if len(self._history) else None,
            "agent": self._agent.state(),
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Take up what state() gave.

        Raises:
            UserError: it is of another agent.
        """
        try:
            self.steps, self.episodes = state["steps"], state["episodes"]
            self._core.set_random_state(state["randomness"])
            self._to_redrive = remembered(state["history"])
            self._digest = state["digest"]
            self._agent.load_state(state["agent"])
        except (LookupError, RuntimeError, TypeError, ValueError, AttributeError) as error:
            raise UserError(f"the checkpoint of the run does not fit its config.yaml: {error}") from error

    def _compare(self) -> None:
        if self._core.physics.state_digest() != self._digest:
            self._tell_difference()

    def _tell_difference(self) -> None:
        self._say(
            "note: the episode in progress, driven again, did not come out the same to the last bit: "
            "another machine or other versions; the training goes on, and will not be the unbroken one's"
        )
