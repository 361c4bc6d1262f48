"""Trainings with one robot."""

import pytest

from asddpg.command_line import train_config
from asddpg.errors import UserError
from tools.experiments.one_robot import OPTIONS, one_robot


def test_a_training_by_default_is_given_all_of_the_options() -> None:
    assert one_robot(["task=nav_complex"]) == ("task=nav_complex", *(f"{name}={OPTIONS[name]}" for name in OPTIONS))


def test_what_the_arguments_or_a_preset_of_one_robot_set_stays() -> None:
    assert one_robot(["agent=asddpg_paper"]) == ("agent=asddpg_paper",)
    assert train_config(one_robot(["task=nav_gazebo"])).agent.samples_per_step == 32
    rate = "agent.critic_learning_rate=1e-3"
    added = one_robot([rate])[1:]
    assert [argument.partition("=")[0] for argument in added] == [name for name in OPTIONS if name not in rate]


@pytest.mark.parametrize("agent", ["ddpg", "astd3"])
def test_what_cannot_follow_the_switch_does_not(agent: str) -> None:
    names = [argument.partition("=")[0] for argument in one_robot([f"agent={agent}"])[1:]]
    assert names == [name for name in OPTIONS if name != "agent.critic_follows_switch"]


def test_an_invalid_argument_is_one_sentence() -> None:
    with pytest.raises(UserError, match="did you mean agent.imitation"):
        one_robot(["agent.imitaton=1"])
