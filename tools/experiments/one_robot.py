"""Trainings with one robot and an update after each step, as they were measured: with the defaults of that time."""

from collections.abc import Sequence

from asddpg.command_line import train_config

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
# Where the preset of a task was another.
TASK_OPTIONS = {
    "nav_simple": {"task.min_linear_velocity": "0"},
    "nav_complex": {"task.min_linear_velocity": "0"},
    "nav_gazebo": {"task.min_linear_velocity": "0", "agent.actor_learning_rate": "0.0003", "agent.imitation": "0"},
}


def one_robot(arguments: Sequence[str]) -> tuple[str, ...]:
    """The arguments of a training, and those of OPTIONS and TASK_OPTIONS that they do not name.

    A preset that has one robot by itself, the paper's, stays as it is.

    Raises:
        UserError: an argument is invalid.
    """
    config = train_config(arguments)
    if train_config([each for each in arguments if not each.startswith("robots=")]).robots == 1:
        return (*arguments,)
    agent, added = config.agent, OPTIONS | TASK_OPTIONS.get(config.task.name, {})
    if not agent.assisted or agent.twin_critics or agent.target_noise:
        del added["agent.critic_follows_switch"]  # there Q^A bootstraps from itself
    named = {argument.partition("=")[0] for argument in arguments}
    return (*arguments, *(f"{name}={value}" for name, value in added.items() if name not in named))
