"""From the command line of a training, an evaluation or a play to a checked configuration.

A training begins from presets, those of task=, agent=, network= and reward=. Values are parsed as in all programs, by
asddpg/options.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, TypeVar

import yaml

from asddpg.config import EvaluateConfig, MissionConfig, PlayConfig, TrainConfig, check
from asddpg.errors import UserError, truncated_repr
from asddpg.options.habits import sweep_hint
from asddpg.options.parsing import find_option, flatten, parse_arguments, with_values
from asddpg.options.values import check_stored, read_value
from tasks.errors import TaskError
from tasks.navigation import FOLLOW, SPEEDS
from tasks.options import options_of, suggest_name
from tasks.rewards import REWARDS
from tasks.robots.names import full_robot_name
from tasks.rooms.reading import ROOMS, full_name, is_room

# Presets, one of each group. Those of agent, network and task are in asddpg/conf: what differs from asddpg/config.py.
GROUPS: Mapping[str, Mapping[str, str]] = {
    "task": {
        "nav_empty": "a room without obstacles; dense reward, 30,000 steps",
        "nav_simple": "a room with a few obstacles; dense reward, 60,000 steps",
        "nav_complex": "the paper's complex room; sparse reward, 100,000 steps",
        "nav_gazebo": "a room of tables and chairs; sparse reward, 150,000 steps",
        "nav_office": "a floor of an office; sparse reward, 150,000 steps",
        "nav_anywhere": "another room in each episode; sparse reward, 400,000 steps",
    },
    "agent": {
        "asddpg": "AsDDPG with this project's cures",
        "asddpg_paper": "AsDDPG by the paper's equations and the released code's constants",
        "astd3": "AsDDPG with TD3's critic: two of them, and a smoothed target action",
        "ddpg": "DDPG, without a controller",
    },
    "network": {
        "fc2x100": "two fully connected layers of 100 neurons",
        "fc3x100": "three fully connected layers of 100 neurons",
        "fc3x256": "three fully connected layers of 256 neurons",
    },
    "reward": {
        "dense": "progress towards the goal, less a small price of each step",
        "sparse": "the price of each step alone, until the goal or a crash",
    },
}
# What a resumed run may change: it changes nothing that has been learned.
MAY_CHANGE = ("total_steps", "checkpoint_every", "record.keep", "live", "port", "speed")
BASELINES = ("controller", "random", "move_base", "waypoints")
Driving = TypeVar("Driving", EvaluateConfig, PlayConfig, MissionConfig)
_CONF = Path(__file__).parent / "conf"
ROBOT, ROBOT_OPTION = "robot", "task.robot"  # the short form and the full name of one option
OWN_ROOM = "own_room"  # the preset of a room that is a file or is generated
_SPEEDS = [f"task.{name}" for name in SPEEDS]
_DEFAULTS = {"network": "fc3x256", "task": "nav_complex", "agent": "asddpg"}  # the later overrides the earlier


def train_config(arguments: Sequence[str]) -> TrainConfig:
    """The configuration of a training run; of two arguments for one option the last counts.

    Raises:
        UserError: an argument is wrong, or two contradict one another.
    """
    choices, values = _read_training(arguments)
    presets: dict[str, Any] = {}
    for group, default in _DEFAULTS.items():
        choice = choices.get(group, default)
        path = _CONF / group / f"{choice if choice in GROUPS[group] else OWN_ROOM}.yaml"
        presets |= flatten(yaml.safe_load(path.read_text(encoding="utf-8")))
    if choices.get("task", "nav_complex") not in GROUPS["task"]:
        presets["task.name"] = choices["task"]
    if ROBOT_OPTION in values:
        presets |= dict.fromkeys(_SPEEDS, FOLLOW)
    reward = presets.pop("reward", "dense")  # a preset, which that of the task names
    config = TrainConfig(reward=replace(REWARDS[choices.get("reward", reward)]))
    return _with_values(config, {**presets, **values})


def resumed_config(arguments: Sequence[str], stored: TrainConfig) -> TrainConfig:
    """The configuration of a run that goes on.

    Raises:
        UserError: an argument is wrong, or would change the run's past.
    """
    choices, values = _read_training(arguments)
    if ROBOT_OPTION in values:
        values[ROBOT_OPTION] = _robot(values[ROBOT_OPTION])
    current = {option.name: option.value for option in options_of(stored)}
    changed = [name for name, value in values.items() if name not in MAY_CHANGE and current[name] != value]
    for name in (*choices, *changed):
        raise UserError(f"{name}= would change the past of the run; with resume= go {'=, '.join(MAY_CHANGE)}= alone")
    config: TrainConfig = with_values(stored, values)
    check(config)
    if config.total_steps < stored.total_steps:
        raise UserError(f"total_steps of a run may be raised, not lowered: it has {stored.total_steps}")
    return config


def stored_config(values: Mapping[str, Any]) -> TrainConfig:
    """The configuration of a training from the values of a config.yaml.

    One without `robots` was written when a training had one robot and made an update after each step, one without
    `agent.saturation` before there was that loss.

    Raises:
        UserError: they are not those of this version's options.
    """
    config, found = TrainConfig(), {"agent.saturation": 0.0} | flatten(values)
    if "robots" not in found:
        found |= {"robots": 1, "agent.samples_per_step": found.get("agent.batch_size", config.agent.batch_size)}
    options = {option.name: option for option in options_of(config)}
    names = flatten(asdict(config)).keys() - options.keys()
    for name, value in found.items():
        if name in options:
            found[name] = check_stored(options[name], value)
        elif name not in names or not isinstance(value, str):
            raise UserError(f"it sets {truncated_repr(name)} to {truncated_repr(value)}")
    return _with_values(config, found)


def driver_config(kind: type[Driving], arguments: Sequence[str]) -> Driving:
    """The configuration of an evaluation, of episodes to play, or of missions; UserError where an argument is wrong."""
    config = parse_arguments(kind, arguments, may_repeat=True)
    check(config)
    return config


def _read_training(arguments: Sequence[str]) -> tuple[dict[str, str], dict[str, Any]]:
    """Presets by group, and values by option."""
    options = {option.name: option for option in options_of(TrainConfig)}
    choices: dict[str, str] = {}
    values: dict[str, Any] = {}
    for argument in arguments:
        name, equals, text = argument.partition("=")
        if name in GROUPS and equals:
            choices[name] = _choice(name, text)
        else:
            full = f"{ROBOT_OPTION}={text}" if name == ROBOT and equals else argument
            option = find_option(full, options, ["resume", ROBOT, *GROUPS])
            values[option.name] = read_value(option, text)
    return choices, values


def _choice(group: str, name: str) -> str:
    if group == "agent" and name in BASELINES:
        command = f"python -m asddpg.evaluate agent={name} task="
        raise UserError(f"agent={name} learns nothing, so there is nothing to train; drive it: {command}")
    if group == "task" and name not in GROUPS[group] and is_room(name):
        return full_name(name)
    if name not in GROUPS[group]:
        rooms = f", or {ROOMS}" if group == "task" else ""
        names = f"there are {', '.join(GROUPS[group])}{rooms}{sweep_hint(group, name)}"
        known = suggest_name(name, GROUPS[group], names)
        raise UserError(f"there is no {group} {truncated_repr(name)}; {known}")
    return name


def _robot(name: str) -> str:
    try:
        return full_robot_name(name)
    except TaskError as error:
        raise UserError(str(error)) from error


def _with_values(config: TrainConfig, values: Mapping[str, Any]) -> TrainConfig:
    try:
        changed: TrainConfig = with_values(config, values)
    except TaskError as error:
        raise UserError(str(error)) from error
    check(changed)
    return changed
