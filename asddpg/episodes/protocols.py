"""What the parts exchange: decisions, steps, and the protocols of environment, agent, controller and observer."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol, SupportsFloat, runtime_checkable

import numpy as np
import numpy.typing as npt

Observation = npt.NDArray[np.float32]  # (observation_size,)
Action = npt.NDArray[np.float32]  # (action_size,), physical units


class Driver(StrEnum):
    """The source of the executed action."""

    POLICY = "policy"
    CONTROLLER = "controller"
    RANDOM = "random"
    PLANNER = "planner"
    OWN = "own"  # of a user


@dataclass(frozen=True, slots=True)
class Decision:
    """What an agent chose in one step, and what it weighed; None where the agent has no such thing."""

    action: Action  # executed, within the action space
    driver: Driver
    actor_action: Action | None = None  # before noise
    controller_action: Action | None = None
    noise: Action | None = None  # added to the actor's action
    q_policy: float | None = None  # Q(x, σ = policy)
    q_controller: float | None = None  # Q(x, σ = controller)
    value: float | None = None  # V(x) of the switch branch


@dataclass(frozen=True, slots=True)
class Step:
    """One step of an episode, as learners and observers see it."""

    observation: Observation
    decision: Decision
    reward: float
    next_observation: Observation
    terminated: bool  # ended: nothing follows, discount 0
    truncated: bool  # broken off by the time limit: the next state still has its value
    info: Mapping[str, Any]


class Environment(Protocol):
    """The part of gymnasium.Env that the loop uses."""

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode."""

    def step(self, action: Any) -> tuple[Observation, Any, bool, bool, dict[str, Any]]:
        """Drive for one control step: observation, reward, terminated, truncated, info."""


class Agent(Protocol):
    """A driver: a policy, a controller, an agent that learns while it drives."""

    def begin_episode(self) -> None:
        """Reset what belongs to one episode."""

    def decide(self, observation: Observation) -> Decision:
        """Choose the next action."""

    def learn(self, step: Step) -> Mapping[str, SupportsFloat]:
        """Learn from a step; returns named metrics, none where nothing was learned."""


class Controller(Protocol):
    """A controller: any object with this method.

    A controller of one's own is named in the configuration as `controller.type=package.module:Factory` and made by
    `Factory(gains=(…), low=…, high=…)`, low and high being the bounds of the action space. One that has a
    memory also has state(), plain values and arrays, and load_state(state): a resumed training needs them.
    """

    def act(self, observation: Observation) -> Action:
        """The action for a flat observation, within the action space, physical units: float32 (action_size,)."""


class Stateful(Protocol):
    """Something whose state can be saved."""

    def state(self) -> Mapping[str, Any]:
        """All that its next steps depend on: plain values and arrays."""

    def load_state(self, state: Mapping[str, Any]) -> Any:
        """Restore what state() returned; an environment returns observation and info of that instant."""


@runtime_checkable
class StatefulController(Controller, Stateful, Protocol):
    """A controller with a memory of earlier observations."""


class Observer(Protocol):
    """Is notified of episodes; changes nothing. A class derived from it defines the methods that it needs."""

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """An episode begins."""
        return

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """A step was made."""
        return

    def end_episode(self, episode: "Episode") -> None:
        """The episode is over."""
        return


@dataclass
class Episode:
    """Statistics of an episode."""

    outcome: str = "cut"  # as info names it: reached, crashed, timeout; else ended, timeout, or cut for one broken off
    steps: int = 0
    total_reward: float = 0.0
    controller_steps: int = 0
    path_length: float = 0.0  # metres driven; 0 where info holds no pose

    @property
    def controller_share(self) -> float:
        """Share of the steps that the controller drove."""
        return self.controller_steps / self.steps if self.steps else 0.0
