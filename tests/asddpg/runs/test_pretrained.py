"""Every policy that is shipped: its files, its card, and that it still drives as its card says."""

import json

import pytest

from asddpg.build import make_agent, make_environment
from asddpg.episodes.drivers import actor_alone
from asddpg.episodes.loop import run_episode
from asddpg.runs import weights_file
from asddpg.runs.loading import open_trained
from asddpg.runs.pretrained import FOLDER, names, open_pretrained
from tasks.evaluation_pairs import stored_pairs
from tests.support import pretrained_checks

# What models/pretrained holds; whoever publishes a policy writes its name here, so that none is lost unnoticed.
SHIPPED: tuple[str, ...] = ("nav_anywhere", "nav_complex", "nav_empty", "nav_gazebo", "nav_simple")
EPISODES, LOST_AT_MOST = 20, 2  # ten points


def test_all_that_is_shipped_is_there_and_nothing_else() -> None:
    assert names() == sorted(SHIPPED)


@pytest.mark.parametrize("name", SHIPPED)
def test_files_and_card(name: str) -> None:
    folder = open_pretrained(name)
    pretrained_checks.check_files(folder)
    pretrained_checks.check_front_matter(folder)
    pretrained_checks.check_nothing_but_tensors(folder)
    pretrained_checks.check_the_cards_command(folder)
    names_in_it = pretrained_checks.run_the_cards_snippet(folder)
    tested = json.loads(folder.test.read_text())
    reach, crash = (tested["actor"][rate]["value"] for rate in ("success_rate", "collision_rate"))
    assert f"| success rate | {reach:.3f} [" in folder.card.read_text()
    alone = tested["controller"]["success_rate"]["value"]
    listed = f"| [{name}]({name}/card.md) | {reach:.3f} | {crash:.3f} | {alone:.3f} |"
    assert listed in (FOLDER / "README.md").read_text(encoding="utf-8")
    assert names_in_it["policy"].step > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_it_drives_as_it_did(name: str) -> None:
    """On the same pairs as its test: another processor or version may flip an outcome, not many."""
    opened, tested = open_trained(f"pretrained:{name}"), json.loads(open_pretrained(name).test.read_text())
    task = opened.config.task
    environment = make_environment(task, opened.config.reward)
    agent = make_agent(opened.config, environment)
    weights_file.load_into(opened.weights, agent.networks)
    pairs = stored_pairs(task.name, "test", task.goal_radius)[:EPISODES]
    outcomes = [run_episode(environment, actor_alone(agent), options=pair.reset_options).outcome for pair in pairs]
    assert outcomes.count("reached") >= tested["outcomes"][:EPISODES].count("reached") - LOST_AT_MOST
