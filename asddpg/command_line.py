"""From the command line of a training, an evaluation or a play to a checked configuration.

Hydra composes the presets of a training, those of task=, agent=, network= and reward=. Values are parsed as in all
programs, by asddpg/options.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from functools import reduce
from operator import getitem
from typing import Any

from hydra import compose, initialize_config_module
from hydra.core.config_store import ConfigStore
from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from asddpg.config import EvaluateConfig, PlayConfig, TrainConfig, check
from asddpg.errors import UserError, truncated_repr
from asddpg.options.parsing import find_option, parse_arguments, with_values
from asddpg.options.values import check_value, read_value
from tasks.errors import TaskError
from tasks.options import options_of
from tasks.rewards import REWARDS

# Presets, one of each group; those of agent, network and task are asddpg/conf.
GROUPS: Mapping[str, Mapping[str, str]] = {
    "task": {
        "nav_empty": "a room without obstacles; dense reward, 30,000 steps",
        "nav_simple": "a room with a few obstacles; dense reward, 60,000 steps",
        "nav_complex": "the paper's complex room; sparse reward, 100,000 steps",
        "nav_gazebo": "a room of tables and chairs; sparse reward, 150,000 steps",
        "nav_office": "a floor of an office; sparse reward, 150,000 steps",
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
BASELINES = ("controller", "random")


def train_config(arguments: Sequence[str]) -> TrainConfig:
    """The configuration of a training run; of two arguments for one option the last counts.

    Raises:
        UserError: an argument is wrong, or two contradict one another.
    """
    choices, values = _read_training(arguments)
    store = ConfigStore.instance()
    store.store("train_schema", TrainConfig)
    for name, reward in REWARDS.items():
        store.store(name, dataclasses.asdict(reward), group="reward")
    with initialize_config_module("asddpg.conf", version_base="1.3"):
        composed = compose("train", overrides=[f"{group}={choice}" for group, choice in choices.items()])
    return _finished(composed, values)


def resumed_config(arguments: Sequence[str], stored: TrainConfig) -> TrainConfig:
    """The configuration of a run that goes on.

    Raises:
        UserError: an argument is wrong, or would change the run's past.
    """
    choices, values = _read_training(arguments)
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

    Raises:
        UserError: they are not those of this version's options.
    """
    try:
        return _finished(OmegaConf.merge(OmegaConf.structured(TrainConfig), values), {})
    except (OmegaConfBaseException, OverflowError) as error:
        raise UserError(first_line(error)) from error


def evaluate_config(arguments: Sequence[str]) -> EvaluateConfig:
    """The configuration of an evaluation; UserError where an argument is wrong."""
    config = parse_arguments(EvaluateConfig, arguments, may_repeat=True)
    check(config)
    return config


def play_config(arguments: Sequence[str]) -> PlayConfig:
    """The configuration of episodes to play; UserError where an argument is wrong."""
    config = parse_arguments(PlayConfig, arguments, may_repeat=True)
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
            values[name] = read_value(find_option(argument, options, list(GROUPS)), text)
    return choices, values


def _choice(group: str, name: str) -> str:
    if group == "agent" and name in BASELINES:
        command = f"python -m asddpg.evaluate agent={name} task="
        raise UserError(f"agent={name} learns nothing, so there is nothing to train; drive it: {command}")
    if name not in GROUPS[group]:
        raise UserError(f"there is no {group} {truncated_repr(name)}; there are {', '.join(GROUPS[group])}")
    return name


def _finished(composed: DictConfig | ListConfig, values: Mapping[str, Any]) -> TrainConfig:
    plain = OmegaConf.to_container(composed)
    for option in options_of(TrainConfig):
        check_value(option, reduce(getitem, option.name.split("."), plain))  # type: ignore[arg-type]
    try:
        config: TrainConfig = with_values(OmegaConf.to_object(composed), values)
    except TaskError as error:
        raise UserError(str(error)) from error
    check(config)
    return config


def first_line(error: Exception) -> str:
    """The first line of the deepest cause: Hydra wraps OmegaConf's message in its own."""
    cause: BaseException = error
    while cause.__cause__ is not None:
        cause = cause.__cause__
    lines = [line.strip() for line in str(cause).splitlines()]
    key = next((line.removeprefix("full_key: ") for line in lines if line.startswith("full_key: ")), "")
    return f"{key}: {lines[0]}" if key else lines[0]
