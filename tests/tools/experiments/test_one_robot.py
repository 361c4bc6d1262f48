"""Trainings with one robot."""

import pytest

from asddpg.command_line import train_config
from asddpg.errors import UserError
from tools.experiments.one_robot import OPTIONS, TASK_OPTIONS, one_robot


def names_added(*arguments: str) -> list[str]:
    added = one_robot(arguments)
    assert added[: len(arguments)] == arguments
    return [argument.partition("=")[0] for argument in added[len(arguments) :]]


def test_a_training_by_default_is_given_all_of_the_options() -> None:
    assert names_added("task=nav_empty") == [*OPTIONS]
    assert names_added("task=nav_complex") == [*OPTIONS, *TASK_OPTIONS["nav_complex"]]


def test_in_a_room_whose_preset_was_another_it_has_that_one() -> None:
    gazebo = train_config(one_robot(["task=nav_gazebo"]))
    assert (gazebo.agent.samples_per_step, gazebo.agent.actor_learning_rate) == (32, 0.0003)
    assert gazebo.task.min_linear_velocity == 0.0


def test_what_the_arguments_name_stays() -> None:
    assert names_added("agent.critic_learning_rate=1e-3", "task=nav_empty") == [
        name for name in OPTIONS if name != "agent.critic_learning_rate"
    ]


def test_the_papers_preset_stays_as_it_is() -> None:
    for arguments in (["agent=asddpg_paper"], ["agent=asddpg_paper", "robots=1"]):
        assert one_robot(arguments) == (*arguments,)


@pytest.mark.parametrize("agent", ["ddpg", "astd3"])
def test_what_cannot_follow_the_switch_does_not(agent: str) -> None:
    assert names_added(f"agent={agent}", "task=nav_empty") == [
        name for name in OPTIONS if name != "agent.critic_follows_switch"
    ]


def test_an_invalid_argument_is_one_sentence() -> None:
    with pytest.raises(UserError, match="did you mean agent.imitation"):
        one_robot(["agent.imitaton=1"])
