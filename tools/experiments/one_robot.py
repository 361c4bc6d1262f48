"""Trainings with one robot and an update after each step, as the ablation measured them: with their time's defaults."""

from collections.abc import Sequence
from dataclasses import asdict

from asddpg.command_line import train_config
from asddpg.config import TrainConfig
from asddpg.options.parsing import flatten

OPTIONS = {
    "robots": "1",
    "agent.batch_size": "32",
    "agent.samples_per_step": "32",
    "agent.tau": "0.005",
    "agent.actor_learning_rate": "0.0001",
    "agent.critic_learning_rate": "0.0003",
    "agent.saturation": "0",
    "agent.critic_follows_switch": "true",
}


def one_robot(arguments: Sequence[str]) -> tuple[str, ...]:
    """The arguments of a training, and those of OPTIONS that neither they nor their presets set.

    A preset that has one robot by itself sets them all.

    Raises:
        UserError: an argument is invalid.
    """
    training, default = train_config(arguments), TrainConfig()
    named = {argument.partition("=")[0] for argument in arguments}
    if training.robots != default.robots and "robots" not in named:
        return (*arguments,)
    config, defaults = flatten(asdict(training)), flatten(asdict(default))
    unset = [name for name in OPTIONS if name not in named and config[name] == defaults[name]]
    if not training.agent.assisted:
        unset.remove("agent.critic_follows_switch")  # there is no switch
    return (*arguments, *(f"{name}={OPTIONS[name]}" for name in unset))
