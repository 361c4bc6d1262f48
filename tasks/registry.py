"""The tasks by name, and how to load one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

import mujoco
from dm_control.rl import control

from tasks.errors import TaskError
from tasks.generator_state import RandomSource, make_generator
from tasks.navigation import Navigation, NavigationConfig
from tasks.options import build_options
from tasks.rewards import REWARDS, Reward
from tasks.room_geometry.held_out import held_out_goals
from tasks.room_geometry.start_goal import FreeSpaceRule, OriginRule, PairRule
from tasks.scene.loading import TASK_CAMERAS, open_scene, scene_path

T = TypeVar("T")


@dataclass(frozen=True)
class TaskDefinition:
    """A task's own settings; its scene has its name.

    Attributes:
        reward: name of its default reward.
        rule: makes the rule of its starts and goals from the compiled scene.
    """

    reward: str
    rule: Callable[[mujoco.MjModel], PairRule]


# Sparse in the complex room, as in the paper (section V-C), and in the rooms harder than that.
# 8 m are 16 s at full speed, of the 40 s of an episode. 1.5 m keep the goal's circle off the start and still give, in
# the gazebo room, paths round a single table; in the large office most paths of 3 m and more leave the room.
DEFINITIONS: Mapping[str, TaskDefinition] = {
    "nav_empty": TaskDefinition("dense", OriginRule),
    "nav_simple": TaskDefinition("dense", OriginRule),
    "nav_complex": TaskDefinition("sparse", OriginRule),
    "nav_gazebo": TaskDefinition("sparse", partial(FreeSpaceRule, min_path=1.5, max_path=8.0)),
    "nav_office": TaskDefinition("sparse", partial(FreeSpaceRule, min_path=3.0, max_path=8.0)),
}

ALL_TASKS: tuple[str, ...] = tuple(DEFINITIONS)


def load(
    task_name: str,
    random: RandomSource = None,
    reward: str | Reward | Mapping[str, Any] | None = None,
    config: NavigationConfig | Mapping[str, Any] | None = None,
) -> control.Environment:
    """Load a task as a dm_control environment.

    Args:
        task_name: one of ALL_TASKS.
        random: seed, generator or RandomState of starts and goals; None draws a fresh seed.
        reward: `dense`, `sparse`, a Reward or a mapping of its options; None takes the task's default.
        config: constants of the task, or a mapping of some; None takes the paper's.

    Raises:
        TaskError: no such task or reward, a constant out of range, or the scene file is broken.
    """
    definition = _find(DEFINITIONS, "task", task_name)
    config = build_options(NavigationConfig, "config", {} if config is None else config)
    reward = definition.reward if reward is None else reward
    physics = open_scene(scene_path(task_name), TASK_CAMERAS, config.laser.num_beams)
    task = Navigation(
        config,
        _find(REWARDS, "reward", reward) if isinstance(reward, str) else build_options(Reward, "reward", reward),
        make_generator(random),
        held_out_goals(task_name),
        make_rule(task_name, physics.model.ptr),
    )
    return control.Environment(physics, task, control_timestep=config.control_timestep)


def make_rule(task_name: str, model: mujoco.MjModel) -> PairRule:
    """The rule of a task's starts and goals in its compiled scene; TaskError where the scene leaves none."""
    try:
        return _find(DEFINITIONS, "task", task_name).rule(model)
    except TaskError as error:
        raise TaskError(f"the scene {scene_path(task_name)} gives no starts and goals: {error}") from error


def _find(table: Mapping[str, T], kind: str, name: str) -> T:
    if not isinstance(name, str) or name not in table:
        raise TaskError(f"there is no {kind} {name!r}; there are {', '.join(table)}")
    return table[name]
