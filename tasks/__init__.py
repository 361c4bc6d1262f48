"""Navigation tasks for a Pioneer 3-DX in MuJoCo: dm_control environments, also registered with Gymnasium."""

from tasks.graphics import headless  # noqa: F401  # first: before anything imports mujoco
from tasks.gymnasium_api.navigation_env import gymnasium_id, register
from tasks.laser import LaserConfig
from tasks.navigation import NavigationConfig
from tasks.registry import ALL_TASKS, load
from tasks.rewards import Reward

__all__ = ["ALL_TASKS", "LaserConfig", "NavigationConfig", "Reward", "gymnasium_id", "load"]

register()
