"""Properties of every registered task; a new task is tested by its registration."""

import itertools
from collections import Counter
from typing import Any

import dm_env
import gymnasium
import numpy as np
import pytest
from absl.testing import absltest
from dm_control.suite.wrappers import action_noise
from dm_env import test_utils
from gymnasium.utils.env_checker import check_env

import tasks
from tasks.evaluation_pairs import draw_room_pairs
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.registry import ROOM_TASKS
from tasks.room_geometry import held_out
from tasks.rooms.changing_room import FIRST_NUMBER, GENERATED

EVERY_TASK = pytest.mark.parametrize("name", tasks.ALL_TASKS)
EVERY_ROOM = pytest.mark.parametrize("name", ROOM_TASKS)
PAPER_ROOMS = ("nav_empty", "nav_simple", "nav_complex")

# The first and the hundredth goal, metres.
DRAWN_WITH_SEED_7 = {
    "nav_empty": ((0.925706452874536, 2.9393821271748584), (-3.279869718292416, 3.665676279774577)),
    "nav_simple": ((0.925706452874536, 2.9393821271748584), (3.1122323929730724, -2.78697753434595)),
    "nav_complex": ((0.925706452874536, 2.9393821271748584), (-3.400086436778654, -1.3664039731855775)),
}


def drive(environment: Any, steps: int, seed: int = 0) -> list[dm_env.TimeStep]:
    """Random commands; the time steps, resets included."""
    rng = np.random.default_rng(seed)
    spec = environment.action_spec()
    return [environment.step(rng.uniform(spec.minimum, spec.maximum)) for _ in range(steps)]


@EVERY_TASK
def test_the_same_seed_gives_the_same_trajectory_and_another_seed_another_goal(name: str) -> None:
    environments = [tasks.load(name, random=seed) for seed in (3, 3, 4)]
    first, second, other = (drive(environment, 60) for environment in environments)
    np.testing.assert_equal(first, second)
    assert not np.array_equal(other[0].observation["goal"], first[0].observation["goal"])


@EVERY_TASK
def test_observations_stay_within_their_spec_share_no_memory_and_are_never_constant(name: str) -> None:
    environment = tasks.load(name, random=0)
    spec = environment.observation_spec()
    steps = drive(environment, 150)
    for before, after in itertools.pairwise(steps):
        for key, part in after.observation.items():
            spec[key].validate(part)
            assert not np.shares_memory(part, before.observation[key])
    for key in spec:
        assert np.all(np.ptp([step.observation[key] for step in steps], axis=0) > 0), key


@pytest.mark.parametrize("name", PAPER_ROOMS)
def test_the_rooms_of_the_paper_keep_the_released_codes_rule_and_draw_the_same_goals_in_every_version(
    name: str,
) -> None:
    """Runs by seed of earlier versions can be repeated only if not a bit of a draw changes."""
    environment = tasks.load(name, random=7)
    goals = []
    for _ in range(300):
        environment.reset()
        goals.append(environment.physics.goal())
        assert environment.physics.pose() == (0.0, 0.0, 0.0)
    assert (goals[0], goals[99]) == DRAWN_WITH_SEED_7[name]
    assert np.all(np.abs(goals) <= 3.7)
    assert not np.any(np.all(np.abs(goals) < 2.0, axis=1))


@EVERY_ROOM
def test_stored_sets_have_their_sizes_and_a_path_from_every_free_start_to_every_free_goal(name: str) -> None:
    environment = tasks.load(name)
    sizes: dict[held_out.SetName, int] = {"validation": 50, "test": 200}
    for set_name, size in sizes.items():
        pairs = held_out.held_out_pairs(name, set_name)
        assert len(pairs) == size
        for pair in pairs:
            straight = np.hypot(pair.goal[0] - pair.start.x, pair.goal[1] - pair.start.y) - 0.3
            longest = 2 * straight + 1 if name in PAPER_ROOMS else 8.0
            assert straight - 0.06 <= pair.shortest_path <= longest
            environment.task.set_next_pair(environment.physics, pair.start, pair.goal)


# A recommendation for learners; an action here is in m/s and rad/s, and gymnasium.wrappers.RescaleAction scales it.
@pytest.mark.filterwarnings("ignore:.*symmetric and normalized")
@EVERY_TASK
def test_gymnasiums_checker_finds_no_fault(name: str) -> None:
    environment = gymnasium.make(tasks.gymnasium_id(name), render_mode="rgb_array")
    check_env(environment.unwrapped)
    environment.close()


@EVERY_TASK
def test_actions_are_in_physical_units(name: str) -> None:
    environment = gymnasium.make(tasks.gymnasium_id(name))
    space = environment.action_space
    assert isinstance(space, gymnasium.spaces.Box)
    np.testing.assert_allclose(space.low, np.array([0.0, -np.pi / 3]), rtol=1e-6)
    np.testing.assert_allclose(space.high, np.array([0.5, np.pi / 3]), rtol=1e-6)
    assert environment.observation_space.shape == (124,)


@EVERY_ROOM
def test_held_out_sets_are_what_the_tool_draws(name: str) -> None:
    from tools.draw_held_out import stored_text

    assert stored_text(name) == (held_out.FOLDER / f"{name}.json").read_text()


def test_pairs_of_nav_anywhere_are_what_the_tool_draws_and_stand_free_in_rooms_below_those_of_trainings() -> None:
    environment = NavigationEnv("nav_anywhere")
    for set_name, per_room in (("validation", 1), ("test", 2)):
        pairs = held_out.held_out_pairs("nav_anywhere", set_name)
        assert Counter(Counter(pair.room for pair in pairs).values()) == {per_room: len(pairs) // per_room}
        assert {pair.room.partition(":")[0] for pair in pairs} == set(GENERATED)
        assert all(int(pair.room.partition(":")[2]) < FIRST_NUMBER for pair in pairs)
        for room in {pair.room: None for pair in pairs[: 14 * per_room]}:  # two of each generator
            assert [pair for pair in pairs if pair.room == room] == list(draw_room_pairs(room, per_room, 0.3))
        for pair in pairs[:: len(pairs) // 50]:
            straight = np.hypot(pair.goal[0] - pair.start.x, pair.goal[1] - pair.start.y) - 0.3
            assert straight - 0.06 <= pair.shortest_path < 30.0
            environment.reset(options=pair.reset_options)


class TestDmEnvConformance(test_utils.EnvironmentTestMixin, absltest.TestCase):  # type: ignore[misc]
    def make_object_under_test(self) -> dm_env.Environment:
        return tasks.load("nav_complex", random=0)


def test_dm_controls_wrappers_and_seeds_take_the_tasks() -> None:
    environments = [tasks.load("nav_office", random=np.random.RandomState(3)) for _ in range(2)]
    starts = [environment.reset() and environment.task.start for environment in environments]
    assert starts[0] == starts[1]
    for environment in environments:
        environment.task._random = np.random.RandomState(4)  # as Shimmy seeds
    noisy, plain = action_noise.Wrapper(environments[0]), environments[1]
    assert noisy.reset().observation.keys() == plain.reset().observation.keys()
    assert noisy.task.start == plain.task.start != starts[0]
    assert not np.array_equal(noisy.step([0.3, 0.0]).observation["goal"], plain.step([0.3, 0.0]).observation["goal"])
    assert plain.physics.state().shape == plain.physics.get_state().shape
