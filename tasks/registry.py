"""The tasks by name, and how to load one."""

import reprlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, TypeVar

import mujoco
import numpy as np
from dm_control.rl import control

from tasks.errors import TaskError
from tasks.generator_state import RandomSource, make_generator
from tasks.laser import BeamRing
from tasks.navigation import Navigation, NavigationConfig
from tasks.options import build_options, suggest_name
from tasks.physics import FloatArray
from tasks.rewards import REWARDS, Reward
from tasks.robots.names import PIONEER
from tasks.robots.opening import open_robot
from tasks.robots.replacement import replace_robot
from tasks.room_geometry.held_out import held_out_goals
from tasks.room_geometry.start_goal import FreeSpaceRule, OriginRule, PairRule
from tasks.rooms.changing_room import ChangingRoom, turning_radius
from tasks.rooms.generators.catalogue import GENERATORS
from tasks.rooms.pairs import draw_sets
from tasks.rooms.reading import ROOMS, find_room, is_room
from tasks.rooms.room import Room
from tasks.rooms.room_rule import RoomRule
from tasks.rooms.scene import compile_room, compile_slots
from tasks.rooms.solid.mjcf_room import read_mjcf
from tasks.scene.loading import TASK_CAMERAS, load_model, robot_physics, scene_path

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


# Of a room that is a file or is generated: what lies 3 m to 8 m away, as in the office, need not exist in it.
OWN_ROOM = TaskDefinition("sparse", RoomRule)

ROOM_TASKS: tuple[str, ...] = tuple(DEFINITIONS)  # of one room each, which is a scene's file
# A room for each episode, from a mixture of generators and of those rooms.
ANYWHERE = "nav_anywhere"
ALL_TASKS: tuple[str, ...] = (*ROOM_TASKS, ANYWHERE)


def load(
    task_name: str,
    random: RandomSource = None,
    reward: str | Reward | Mapping[str, Any] | None = None,
    config: NavigationConfig | Mapping[str, Any] | None = None,
) -> control.Environment:
    """Load a task as a dm_control environment.

    Args:
        task_name: one of ALL_TASKS, or a room: a file, or a generated one.
        random: seed, generator or RandomState of starts and goals; None draws a fresh seed.
        reward: `dense`, `sparse`, a Reward or a mapping of its options; None takes the task's default.
        config: constants of the task, or a mapping of some; None takes the paper's.

    Raises:
        TaskError: no such task or reward, a constant out of range, or the scene file is broken.
    """
    reward_name = find_task(task_name).reward
    config = build_options(NavigationConfig, "config", {} if config is None else config)
    reward = reward_name if reward is None else reward
    model = task_model(task_name, config.laser.ring, config.robot)
    physics = robot_physics(model, task_name, TASK_CAMERAS)
    rule: PairRule
    if task_name == ANYWHERE:
        radius = turning_radius(config.robot, physics.model.ptr)
        _check_mixture(config.rooms)
        rule = ChangingRoom(config.rooms, partial(_find_task_room, robot=config.robot), radius)
    else:
        rule = make_rule(task_name, physics.model.ptr)
    task = Navigation(
        config,
        _find(REWARDS, "reward", reward) if isinstance(reward, str) else build_options(Reward, "reward", reward),
        make_generator(random),
        _held_out(task_name, rule),
        rule,
    )
    return control.Environment(physics, task, control_timestep=config.control_timestep)


def find_task(name: str) -> TaskDefinition:
    """The definition of a task, or that of all rooms; TaskError where a name is neither's."""
    if name == ANYWHERE:
        return TaskDefinition("sparse", RoomRule)
    if isinstance(name, str) and name not in DEFINITIONS and is_room(name):
        return OWN_ROOM
    if not isinstance(name, str) or name not in DEFINITIONS:
        known = suggest_name(str(name), ALL_TASKS, f"there are {', '.join(ALL_TASKS)}, or {ROOMS}")
        raise TaskError(f"there is no task {reprlib.repr(name)}; {known}")
    return DEFINITIONS[name]


def task_model(name: str, ring: BeamRing | None = None, robot: str = PIONEER) -> mujoco.MjModel:
    """The compiled scene of a task or of a room.

    Args:
        name: of the task or the room.
        ring: beams of the laser; None leaves the scene's own.
        robot: that drives in it.

    Raises:
        TaskError: there is no such task, room or robot, its file is broken, or the robot does not obey.
    """
    open_robot(robot)
    if name == ANYWHERE:
        return compile_slots(ring, robot)
    if find_task(name) is OWN_ROOM:
        return compile_room(find_room(name), ring, robot)
    return load_model(scene_path(name), ring, partial(replace_robot, name=robot))


def make_rule(task_name: str, model: mujoco.MjModel) -> PairRule:
    """The rule of a task's starts and goals in its compiled scene; TaskError where the scene leaves none."""
    definition = find_task(task_name)
    try:
        return definition.rule(model)
    except TaskError as error:
        scene = task_name if definition is OWN_ROOM else scene_path(task_name)
        raise TaskError(f"the scene {scene} gives no starts and goals: {error}") from error


def _held_out(task_name: str, rule: PairRule) -> FloatArray:
    """Goals that no drawn goal comes near, (n, 2) metres: those of the evaluation sets, but not a room's own."""
    if isinstance(rule, ChangingRoom):
        return np.zeros((0, 2))
    if not isinstance(rule, RoomRule):
        return held_out_goals(task_name)
    room = find_room(task_name)
    sets = {} if room.pairs else draw_sets(room, rule)
    return np.array([pair.goal for pairs in sets.values() for pair in pairs]).reshape(-1, 2)


def _check_mixture(names: Sequence[str]) -> None:
    """TaskError where task.rooms names something else than generators and tasks of one room."""
    valid = (*GENERATORS, *ROOM_TASKS)
    wrong = [name for name in names if name not in valid]
    if wrong or not names:
        found = f", not {reprlib.repr(wrong[0])}" if wrong else ""
        raise TaskError(f"rooms of {ANYWHERE} are {', '.join(valid)}{found}")


@cache
def _find_task_room(name: str, robot: str) -> tuple[PairRule, FloatArray, Room]:
    """Rule, held-out goals and room of a task, for task=nav_anywhere."""
    _check_mixture([name])
    return make_rule(name, task_model(name, robot=robot)), held_out_goals(name), read_mjcf(scene_path(name))


def _find(table: Mapping[str, T], kind: str, name: str) -> T:
    if not isinstance(name, str) or name not in table:
        raise TaskError(f"there is no {kind} {name!r}; there are {', '.join(table)}")
    return table[name]
