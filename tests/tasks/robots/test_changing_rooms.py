"""A robot of a user's in rooms that change."""

import numpy as np
import pytest

from tasks.evaluation_pairs import stored_pairs
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.gymnasium_api.navigation_vector_env import NavigationVectorEnv
from tasks.room_geometry.footprints import Footprint
from tasks.room_geometry.start_goal import MARGIN
from tasks.variation import Variation, VariedBody

BURGER = "turtlebot3_burger"
CONFIG = {
    "robot": BURGER,
    "goal_range": 3.0,
    "laser": {"num_beams": 60, "rays_per_beam": 3, "field_of_view": 360.0, "max_range": 3.5, "noise": 1.0},
    "variation": {"mass": 0.3, "friction": 0.3, "latency": 0.2},
}


def test_it_starts_where_it_can_turn_and_its_obstacles_are_there() -> None:
    environment = NavigationEnv("nav_anywhere", config=CONFIG)
    least = Footprint.from_model(environment.physics.model.ptr).radius + MARGIN
    outcomes = []
    for seed in range(6):
        _, info = environment.reset(seed=seed)
        assert environment.obstacles.clearance(info["start"][:2]) > least - 0.01
        over = False
        while not over:
            *_, terminated, truncated, info = environment.step(np.array([0.22, 0.0]))
            over = terminated or truncated
        outcomes.append(info["outcome"])
        assert info["outcome"] != "crashed" or environment.physics.touched()
    assert "crashed" in outcomes


def test_robots_of_a_vector_equal_single_ones() -> None:
    vector, single = NavigationVectorEnv("nav_anywhere", 2, config=CONFIG), NavigationEnv("nav_anywhere", config=CONFIG)
    np.testing.assert_array_equal(vector.reset(seed=5)[0][1], single.reset(seed=6)[0])
    action = np.array([0.15, 0.4])
    for _ in range(10):
        np.testing.assert_array_equal(vector.step(np.stack([action, action]))[0][1], single.step(action)[0])
    vector.close()


@pytest.mark.parametrize(("robot", "part"), [("pioneer", "base"), (BURGER, "robot_base")])
def test_the_mass_that_varies_is_that_of_its_heaviest_part(robot: str, part: str) -> None:
    physics = NavigationEnv("nav_empty", config={"robot": robot}).physics
    body = physics.model.ptr.body(part)
    before = float(body.mass[0])
    VariedBody(physics.model.ptr).apply(physics, *Variation(mass=1.5)[3:])
    assert before > 0.5
    assert float(body.mass[0]) == pytest.approx(1.5 * before)


def test_it_is_evaluated_along_the_stored_pairs_that_it_fits_in() -> None:
    pairs, own = (stored_pairs("nav_anywhere", "validation", 0.3, 7, robot) for robot in (BURGER, "pioneer"))
    assert [pair.reset_options for pair in pairs] == [pair.reset_options for pair in own]
    assert all(pair.shortest_path <= 1.1 * other.shortest_path for pair, other in zip(pairs, own, strict=True))


def test_its_laser_is_moved_alone() -> None:
    plain, model = (
        NavigationEnv("nav_empty", config={"robot": BURGER, "laser": {"height": height}}).physics.model.ptr
        for height in (None, 0.3)
    )
    np.testing.assert_array_equal(plain.geom_pos, model.geom_pos)
    np.testing.assert_array_equal(plain.body_mass, model.body_mass)
    assert model.body("laser").pos[2] == pytest.approx(0.3)
