"""From the words of a command line to a checked configuration, by Hydra."""

import dataclasses
import difflib
from collections.abc import Callable, Sequence
from typing import TypeVar

from hydra import compose, initialize_config_module
from hydra.core.config_store import ConfigStore
from hydra.core.override_parser.types import Override
from hydra.errors import HydraException
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from asddpg.config import EvaluateConfig, PlayConfig, TrainConfig, check
from asddpg.errors import UserError, truncated_repr
from asddpg.option_types import check_value, kinds_of, parse
from tasks import ALL_TASKS
from tasks.rewards import REWARDS

Config = TypeVar("Config", TrainConfig, EvaluateConfig, PlayConfig)

GROUPS = {
    "task": ALL_TASKS,
    "agent": ("asddpg", "asddpg_paper", "astd3", "ddpg"),
    "network": ("fc2x100", "fc3x100", "fc3x256"),
    "reward": tuple(REWARDS),
}
# What a run that goes on may have otherwise: it changes nothing that has been learned.
MAY_CHANGE = ("total_steps", "checkpoint_every", "record.keep", "live", "port", "speed")
BASELINES = ("controller", "random")


def train_config(arguments: Sequence[str]) -> TrainConfig:
    """The configuration of a training run; UserError where a word is wrong."""
    overrides = _checked_overrides(arguments, TrainConfig, GROUPS)
    _store_schemas()

    def by_groups() -> DictConfig:
        with initialize_config_module("asddpg.conf", version_base="1.3"):
            return compose("train", overrides=[str(override.input_line) for override in overrides])

    return _finished(by_groups, TrainConfig)


def resumed_config(arguments: Sequence[str], stored: TrainConfig) -> TrainConfig:
    """The configuration of a run that goes on; UserError where a word is wrong or would change the run's past."""
    config: DictConfig = OmegaConf.structured(stored)
    overrides = _checked_overrides(arguments, TrainConfig, GROUPS)
    for override in overrides:
        name, value = override.key_or_group, override.value()
        if name not in MAY_CHANGE and (name in GROUPS or OmegaConf.select(config, name) != value):
            raise UserError(
                f"{name}= would change the past of the run; with resume= go {'=, '.join(MAY_CHANGE)}= alone"
            )
    finished = _finished(lambda: _updated(config, overrides), TrainConfig)
    if finished.total_steps < stored.total_steps:
        raise UserError(f"total_steps of a run may be raised, not lowered: it has {stored.total_steps}")
    return finished


def evaluate_config(arguments: Sequence[str]) -> EvaluateConfig:
    """The configuration of an evaluation; UserError where a word is wrong."""
    return _without_groups(arguments, EvaluateConfig)


def play_config(arguments: Sequence[str]) -> PlayConfig:
    """The configuration of episodes to play; UserError where a word is wrong."""
    return _without_groups(arguments, PlayConfig)


def _without_groups(arguments: Sequence[str], kind: type[Config]) -> Config:
    overrides = _checked_overrides(arguments, kind, {})

    return _finished(lambda: _updated(OmegaConf.structured(kind), overrides), kind)


def _updated(config: DictConfig, overrides: Sequence[Override]) -> DictConfig:
    for override in overrides:
        OmegaConf.update(config, override.key_or_group, override.value())
    return config


def _finished(composing: Callable[[], DictConfig], kind: type[Config]) -> Config:
    try:
        config = OmegaConf.to_object(composing())
    except (HydraException, OmegaConfBaseException) as error:
        raise UserError(first_line(error)) from error
    assert isinstance(config, kind)
    check(config)
    return config


def _checked_overrides(
    arguments: Sequence[str], kind: type[Config], groups: dict[str, tuple[str, ...]]
) -> Sequence[Override]:
    # A name says which choice of a group the values are: it is no option of its own.
    kinds = {name: option for name, option in kinds_of(kind).items() if not name.endswith(".name")}
    overrides = [parse(argument, kinds) for argument in arguments]
    for override in overrides:
        _check_name(override, list(kinds), groups)
        if override.key_or_group not in groups:
            check_value(override.key_or_group, kinds[override.key_or_group], override)
    return overrides


def _store_schemas() -> None:
    store = ConfigStore.instance()
    store.store("train_schema", TrainConfig)
    for name, reward in REWARDS.items():
        store.store(name, dataclasses.asdict(reward), group="reward")


def _check_name(override: Override, options: Sequence[str], groups: dict[str, tuple[str, ...]]) -> None:
    name = override.key_or_group
    if name in groups:
        if name == "agent" and override.value() in BASELINES:
            argument = f"python -m asddpg.evaluate agent={override.value()} task="
            raise UserError(
                f"agent={override.value()} learns nothing, so there is nothing to train; drive it: {argument}"
            )
        if override.value() not in groups[name]:
            raise UserError(
                f"there is no {name} {truncated_repr(override.value())}; there are {', '.join(groups[name])}"
            )
    elif name not in options:
        raise UserError(f"there is no option {truncated_repr(name)}; {_suggestion(name, [*groups, *options])}")


def _suggestion(name: str, known: Sequence[str]) -> str:
    last = name.rsplit(".", 1)[-1]
    alike = [option for option in known if option.rsplit(".", 1)[-1] == last]
    alike = alike or difflib.get_close_matches(name, known, n=3, cutoff=0.6)
    if alike:
        return f"did you mean {' or '.join(alike)}?"
    return f"there are {', '.join(known)}"


def option_names(config: DictConfig, prefix: str = "") -> list[str]:
    """Every option by its full name, such as `agent.batch_size`."""
    names: list[str] = []
    for key in config:
        node = config._get_node(key)
        name = f"{prefix}{key!s}"
        names += option_names(node, f"{name}.") if isinstance(node, DictConfig) else [name]
    return names


def first_line(error: Exception) -> str:
    """The first line of the deepest cause: Hydra wraps OmegaConf's message in its own."""
    cause: BaseException = error
    while cause.__cause__ is not None:
        cause = cause.__cause__
    lines = [line.strip() for line in str(cause).splitlines()]
    key = next((line.removeprefix("full_key: ") for line in lines if line.startswith("full_key: ")), "")
    return f"{key}: {lines[0]}" if key else lines[0]
