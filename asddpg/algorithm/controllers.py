"""Controllers that assist, and how to add one."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from asddpg.episodes.batch_steps import Float32Array
from asddpg.episodes.protocols import Action, Controller, Observation, StatefulController
from asddpg.errors import UserError, import_factory


class ProportionalController:
    """P(P_l, P_r) of the paper, section V-B: v = P_l · x_local, ω = P_r · y_local, clipped to the action space.

    It reads the goal in the robot frame from the last two numbers of the observation.
    """

    def __init__(self, gains: Sequence[float], low: Action, high: Action) -> None:
        """Make the controller.

        Args:
            gains: P_l in 1/s and P_r in rad/(s·m).
            low: (2,) smallest v (m/s) and ω (rad/s).
            high: (2,) largest v (m/s) and ω (rad/s).
        """
        self._gains = np.asarray(gains, dtype=np.float32)
        self._low, self._high = low, high

    def act(self, observation: Observation) -> Action:
        """Drive towards the goal, through obstacles too; of observations in rows, all at once."""
        command: Action = self._gains * observation[..., -2:]
        return np.minimum(np.maximum(command, self._low), self._high)


class Controllers:
    """A controller for each robot, since one of a user's own may have a memory.

    Attributes:
        first: that of robot 0.
    """

    def __init__(self, controllers: Sequence[Controller]) -> None:
        """Assist robots with these, one each."""
        self._controllers = controllers
        self.first = controllers[0]

    def act(self, observations: Float32Array) -> Float32Array:
        """The controllers' actions, float32 (n, action_size), for observations in rows."""
        if type(self.first) is ProportionalController:  # one of a user's, derived from it, takes one observation
            return self.first.act(observations)
        actions = [each.act(row) for each, row in zip(self._controllers, observations, strict=True)]
        return np.asarray(actions, dtype=np.float32)

    def state(self) -> list[Any] | None:
        """What the controllers remember; None where they have no memory."""
        return [each.state() for each in self._controllers if isinstance(each, StatefulController)] or None

    def load_state(self, state: Sequence[Any] | None) -> None:
        """Restore what state() returned.

        Raises:
            ValueError: it is of other controllers.
        """
        remembering = [each for each in self._controllers if isinstance(each, StatefulController)]
        for controller, each in zip(remembering, state or (), strict=True):
            controller.load_state(each)


CONTROLLERS = {"proportional": ProportionalController}


def make_controller(kind: str, gains: Sequence[float], low: Action, high: Action) -> Controller:
    """Make a controller by its name here or by `package.module:Factory`.

    Raises:
        UserError: there is no such controller.
    """
    if kind in CONTROLLERS:
        return CONTROLLERS[kind](gains, low, high)
    factory = import_factory(kind)
    if factory is None:
        raise UserError(
            f"there is no controller {kind!r}; there is {', '.join(CONTROLLERS)}, or your own as package.module:Factory"
        )
    try:
        controller: Controller = factory(gains=gains, low=low, high=high)
    except TypeError as error:
        wanted = "package.module:Factory with Factory(gains=…, low=…, high=…)"
        raise UserError(f"the controller {kind!r} cannot be made: {error}; the option is {wanted}") from error
    if not callable(getattr(controller, "act", None)):
        raise UserError(f"the controller {kind!r} has no method act(observation)")
    return controller
