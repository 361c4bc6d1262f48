"""Many robots drive the pairs of an evaluation as one robot drives them."""

from typing import Any

import numpy as np
import pytest

from asddpg.build import controller_for, make_environment, make_robots
from asddpg.command_line import train_config
from asddpg.episodes.drivers import controller_alone
from asddpg.episodes.evaluation import evaluate
from asddpg.episodes.side_by_side import evaluate_side_by_side
from tasks.evaluation_pairs import stored_pairs


@pytest.mark.parametrize("robots", [1, 3, 16])
def test_the_controller_has_the_same_figures(robots: int) -> None:
    """Fewer pairs than robots among them: those without a pair do not count."""
    config = train_config(["task=nav_complex", "task.time_limit_steps=60"])
    pairs = stored_pairs("nav_complex", "validation", config.task.goal_radius)[:7]
    single, together = make_environment(config.task, config.reward), make_robots(config.task, config.reward, robots)
    controller = controller_for(single, config.controller)

    def act(observations: Any) -> Any:
        return np.array([controller.act(observation) for observation in observations])

    timestep = config.task.control_timestep
    found = evaluate_side_by_side(together, act, pairs, timestep)
    expected = evaluate(single, controller_alone(controller), pairs, timestep)
    together.close()
    assert {**found.as_dict(), "controller_share": 1.0} == expected.as_dict()
    assert evaluate_side_by_side(make_robots(config.task, config.reward, robots), act, pairs, timestep) == found
