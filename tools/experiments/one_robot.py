"""Trainings with one robot and an update after each step: Algorithm 1, by which the ablation is measured."""

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
}


def one_robot(arguments: Sequence[str]) -> tuple[str, ...]:
    """The arguments of a training, and those of OPTIONS that neither they nor their presets set.

    Raises:
        UserError: an argument is invalid.
    """
    config, defaults = flatten(asdict(train_config(arguments))), flatten(asdict(TrainConfig()))
    named = {argument.partition("=")[0] for argument in arguments}
    unset = [name for name in OPTIONS if name not in named and config[name] == defaults[name]]
    return (*arguments, *(f"{name}={OPTIONS[name]}" for name in unset))
