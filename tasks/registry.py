"""The tasks by name, and how to load one."""

from collections.abc import Mapping

import numpy as np
from dm_control.rl import control

from tasks.errors import TaskError
from tasks.held_out import held_out_goals
from tasks.navigation import Navigation, NavigationConfig
from tasks.physics import Physics
from tasks.rewards import REWARDS, Reward
from tasks.scenes import scene_path

# Task → its reward where none is asked for: sparse in the complex room, as in the paper (section V-C).
DEFAULT_REWARDS: Mapping[str, str] = {"nav_empty": "dense", "nav_simple": "dense", "nav_complex": "sparse"}

ALL_TASKS: tuple[str, ...] = tuple(DEFAULT_REWARDS)


def load(
    task_name: str,
    random: int | np.random.Generator | None = None,
    reward: str | Reward | None = None,
    config: NavigationConfig | None = None,
) -> control.Environment:
    """Load a task as a dm_control environment.

    Args:
        task_name: one of ALL_TASKS.
        random: seed or generator of starts and goals; None draws a fresh seed.
        reward: `dense`, `sparse` or a Reward; None takes the task's default.
        config: constants of the task; None takes the paper's.

    Raises:
        TaskError: no such task or reward.
    """
    default = default_reward(task_name)
    config = config or NavigationConfig()
    reward = reward or default
    task = Navigation(
        config,
        named_reward(reward) if isinstance(reward, str) else reward,
        np.random.default_rng(random),
        held_out_goals(task_name),
    )
    physics = Physics.from_xml_path(str(scene_path(task_name)))
    return control.Environment(physics, task, control_timestep=config.control_timestep)


def default_reward(task_name: str) -> str:
    """Name of the reward a task takes where none is asked for; TaskError where there is no such task."""
    if task_name not in DEFAULT_REWARDS:
        raise TaskError(f"there is no task {task_name!r}; there are {', '.join(ALL_TASKS)}")
    return DEFAULT_REWARDS[task_name]


def named_reward(name: str) -> Reward:
    """The reward of that name; TaskError where there is none."""
    if name not in REWARDS:
        raise TaskError(f"there is no reward {name!r}; there are {', '.join(REWARDS)}")
    return REWARDS[name]
