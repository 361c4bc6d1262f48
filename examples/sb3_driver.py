"""A policy trained elsewhere, by Stable-Baselines3's DDPG, TD3 or SAC, as a driver of this project's programs.

SB3_MODEL=model.zip python -m tools.compare drivers=[examples.sb3_driver:Factory,controller] tasks=[nav_empty]
"""

import hashlib
import os
from pathlib import Path
from typing import Any

import numpy as np
from stable_baselines3 import SAC, TD3
from stable_baselines3.common.save_util import load_from_zip_file

from asddpg.episodes.protocols import Action, Observation
from asddpg.errors import UserError
from asddpg.planning.robot import Robot


class Factory:
    """The policy without noise; SB3_MODEL names its file, whose actions must be m/s and rad/s.

    Attributes:
        identity: digest of the file, so that tools.compare takes no other model's episodes for its own.
    """

    def __init__(self, robot: Robot) -> None:
        path = Path(os.environ.get("SB3_MODEL", ""))
        if not path.is_file():
            raise UserError(
                "SB3_MODEL must name a file of Stable-Baselines3, as SB3_MODEL=model.zip before the command"
            )
        saved: Any = load_from_zip_file(path, device="cpu")[0]
        kind = SAC if saved["policy_class"].__name__ == "SACPolicy" else TD3  # DDPG is a TD3 with one critic
        self._model = kind.load(path, device="cpu")
        space: Any = self._model.action_space
        low, high = space.low, space.high
        if not np.allclose([low, high], [robot.shape.low, robot.shape.high]):
            raise UserError(
                f"the actions of {path} go from {low} to {high}, not {robot.shape.low} to {robot.shape.high}"
            )
        self.identity = hashlib.sha256(path.read_bytes()).hexdigest()

    def act(self, observation: Observation) -> Action:
        """The action for a flat observation, m/s and rad/s, (2,)."""
        action: Action = self._model.predict(observation, deterministic=True)[0]
        return action
