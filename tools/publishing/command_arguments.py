"""The arguments that make a configuration: train_config's inverse."""

import shlex

from asddpg.command_line import train_config
from asddpg.config import TrainConfig
from asddpg.errors import UserError
from asddpg.options.values import write_value
from tasks.options import options_of

LEFT_OUT = ("run_dir",)  # where a run lay, not what was trained


def command_of(config: TrainConfig) -> str:
    """The command line that trains by a configuration, quoted for a shell.

    Raises:
        UserError: no arguments of this version make that configuration.
    """
    return shlex.join(["python", "-m", "asddpg.train", *arguments_of(config)])


def arguments_of(config: TrainConfig) -> list[str]:
    """The task, then the choices and the options that differ from the task's defaults; not where the run lay.

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
        raise UserError("no arguments of this version make the configuration of this run; train it anew")
    return arguments


def _differences(config: TrainConfig, defaults: TrainConfig) -> list[str]:
    return [
        f"{option.name}={write_value(option.value)}"
        for option, default in zip(options_of(config), options_of(defaults), strict=True)
        if option.value != default.value and option.name not in LEFT_OUT
    ]
