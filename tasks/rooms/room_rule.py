"""The rule of starts and goals in a room that is a file or is generated."""

from functools import cached_property

import mujoco
import numpy as np

from tasks.physics import FloatArray, Pose
from tasks.room_geometry.obstacles import Obstacles
from tasks.room_geometry.start_goal import FreeSpaceRule


class RoomRule:
    """FreeSpaceRule, whose maps are made with the first draw: a room with pairs of its own may need none."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Prepare a room, by its compiled scene."""
        self._model = model
        self.obstacles = Obstacles.from_model(model)

    @cached_property
    def _rule(self) -> FreeSpaceRule:
        return FreeSpaceRule(self._model)

    def draw(self, rng: np.random.Generator, held_out: FloatArray) -> tuple[Pose, tuple[float, float]]:
        """Draw a start and a goal; TaskError where the room leaves none."""
        return self._rule.draw(rng, held_out)

    def __deepcopy__(self, _: object) -> "RoomRule":
        """It never changes: copies of an environment share its maps."""
        return self
