"""Trainings with one robot and an update after each step, as the ablation measured them: with their time's defaults."""

from collections.abc import Sequence

from asddpg.command_line import train_config
from asddpg.config import TrainConfig

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
    """The arguments of a training, and those of OPTIONS that they do not name.

    A preset that has one robot by itself sets them all.

    Raises:
        UserError: an argument is invalid.
    """
    config = train_config(arguments)
    named = {argument.partition("=")[0] for argument in arguments}
    if config.robots != TrainConfig().robots and "robots" not in named:
        return (*arguments,)
    agent, added = config.agent, {name: value for name, value in OPTIONS.items() if name not in named}
    if not agent.assisted or agent.twin_critics or agent.target_noise:
        added.pop("agent.critic_follows_switch", None)  # there Q^A bootstraps from itself
    return (*arguments, *(f"{name}={value}" for name, value in added.items()))
