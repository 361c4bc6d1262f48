"""The words that make a configuration: train_config's inverse."""

import shlex
from collections.abc import Sequence
from typing import Any

from omegaconf import OmegaConf

from asddpg.command_line import option_names, train_config
from asddpg.config import TrainConfig
from asddpg.errors import UserError

LEFT_OUT = ("run_dir",)  # where a run lay, not what was trained


def command_of(config: TrainConfig) -> str:
    """The command line that trains by a configuration, quoted for a shell.

    Raises:
        UserError: no words of this version make that configuration.
    """
    return shlex.join(["python", "-m", "asddpg.train", *words_of(config)])


def words_of(config: TrainConfig) -> list[str]:
    """The words: task, then the choices and the options that differ from the task's defaults; not where it lay.

    Raises:
        UserError: as above.
    """
    arguments = [f"task={config.task.name}"]
    defaults = train_config(arguments)
    for group in ("agent", "reward", "network"):
        name = getattr(config, group).name
        if name != getattr(defaults, group).name:
            arguments.append(f"{group}={name}")
    arguments += _differences(config, train_config(arguments))
    if _differences(config, train_config(arguments)):
        raise UserError("no words of this version make the configuration of this run; train it anew")
    return arguments


def _differences(config: TrainConfig, defaults: TrainConfig) -> Sequence[str]:
    wanted, known = OmegaConf.structured(config), OmegaConf.structured(defaults)
    names = [name for name in option_names(known) if name not in LEFT_OUT and not name.endswith(".name")]
    values = {name: (OmegaConf.select(wanted, name), OmegaConf.select(known, name)) for name in names}
    return [f"{name}={_word(value)}" for name, (value, default) in values.items() if value != default]


def _word(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    if OmegaConf.is_list(value):
        return f"[{','.join(_word(item) for item in value)}]"
    return str(value)
