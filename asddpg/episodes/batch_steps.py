"""What the robots of a training do in one step: arrays with a row for each robot."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from asddpg.episodes.protocols import Action, Decision, Driver, Observation, Step

Float32Array = npt.NDArray[np.float32]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]
Infos = Mapping[str, Any]  # arrays by name, as Gymnasium's vector environments give them


class Decisions(NamedTuple):
    """What an agent chose for n robots, and what it weighed; None where the agent has no such thing."""

    actions: Float32Array  # (n, action_size), executed, within the action space
    by_controller: BoolArray  # (n,)
    actor_actions: Float32Array  # (n, action_size), before noise
    controller_actions: Float32Array | None = None  # (n, action_size)
    noise: Float32Array | None = None  # (n, action_size), added to the actor's action; only where the policy drives
    q: Float32Array | None = None  # (n, 2), Q(x, σ), columns policy and controller
    values: Float32Array | None = None  # (n,), V(x) of the switch branch

    def row(self, robot: int) -> Decision:
        """The decision for one robot."""
        by_controller, q = bool(self.by_controller[robot]), _row(self.q, robot)
        return Decision(
            action=self.actions[robot],
            driver=Driver.CONTROLLER if by_controller else Driver.POLICY,
            actor_action=self.actor_actions[robot],
            controller_action=_row(self.controller_actions, robot),
            noise=None if by_controller else _row(self.noise, robot),
            q_policy=None if q is None else float(q[0]),
            q_controller=None if q is None else float(q[1]),
            value=None if self.values is None else float(self.values[robot]),
        )


class Steps(NamedTuple):
    """One step of n robots."""

    observations: Float32Array  # (n, observation_size)
    decisions: Decisions
    rewards: FloatArray  # (n,)
    next_observations: Float32Array  # (n, observation_size)
    terminated: BoolArray  # (n,)
    truncated: BoolArray  # (n,)
    infos: Infos

    def row(self, robot: int) -> Step:
        """The step of one robot."""
        return Step(
            self.observations[robot],
            self.decisions.row(robot),
            float(self.rewards[robot]),
            self.next_observations[robot],
            bool(self.terminated[robot]),
            bool(self.truncated[robot]),
            info_of(self.infos, robot),
        )


def info_of(infos: Infos, robot: int) -> dict[str, Any]:
    """The info of one robot in plain numbers, as its single environment would give it."""
    plain: dict[str, Any] = {}
    for name, values in infos.items():
        if isinstance(values, Mapping):
            plain[name] = info_of(values, robot)
        elif not name.startswith("_"):  # Gymnasium's masks
            plain[name] = values[robot].tolist() if hasattr(values[robot], "tolist") else values[robot]
    return plain


def _row(values: Float32Array | None, robot: int) -> Observation | Action | None:
    return None if values is None else values[robot]
