"""What a mission's robot knows, and where it is sent."""

import numpy as np
import pytest

from asddpg.missions.environment import Mission
from asddpg.missions.setting import draw_mission
from tasks.errors import TaskError
from tasks.room_geometry.obstacles import Obstacles
from tests.support.missions import Stage, make_stage

CENTRES = {"north": (0.0, 1.25), "south": (0.0, -1.25), "west": (-1.75, 0.0), "east": (1.75, 0.0)}  # of nav_simple


@pytest.fixture(scope="module")
def complex_room() -> Stage:
    return make_stage("task=nav_complex")


def is_on_the_map(stage: Stage, place: tuple[float, float]) -> bool:
    row, column = stage.robot.map.to_cells(place).tolist()
    return bool(stage.robot.map.occupied[row, column])


def test_the_map_lacks_the_unmapped_obstacles_alone() -> None:
    stage = make_stage("task=nav_simple", "unmapped=[north,east]")
    assert stage.setting.unmapped == ("north", "east")
    assert {name: is_on_the_map(stage, place) for name, place in CENTRES.items()} == {
        "north": False, "south": True, "west": True, "east": False
    }  # fmt: skip
    assert is_on_the_map(stage, (4.05, 0.0)), "a wall"
    assert len(stage.environment.obstacles.outlines) - len(stage.setting.known.outlines) == 2


def test_driver_and_mission_share_the_robot() -> None:
    stage = make_stage()
    assert stage.setting.make_robot(stage.environment) is stage.robot is stage.setting.robot


def test_the_task_ends_no_mission_and_the_laser_has_noise() -> None:
    task = make_stage("noise=0.7").environment.task
    assert (task.config.goal_radius, task.laser.config.noise) == (0.0, 0.7)
    assert task.config.time_limit_steps >= 10**6


@pytest.mark.parametrize(("drift", "factor"), [("0", 1.0), ("0.2", 1.2)])
def test_odometry_takes_lengths_for_too_long_by_the_drift(drift: str, factor: float) -> None:
    stage = make_stage(f"drift={drift}")
    stage.missions.reset(options={"mission": Mission((0.0, 0.0, 0.0), ((3.0, 0.0),), seed=1)})
    for _ in range(10):
        stage.missions.step(np.array([0.4, 0.0]))
    assert stage.robot.reading.velocity[0] == pytest.approx(0.4 * factor, rel=0.02)


def test_unmapped_obstacles_are_drawn_by_the_seed_and_are_no_walls(complex_room: Stage) -> None:
    drawn = [make_stage("task=nav_complex", f"seed={seed}").setting.unmapped for seed in (0, 1)]
    assert drawn[0] == complex_room.setting.unmapped
    assert drawn[0] != drawn[1]
    for names in drawn:
        assert len(set(names)) == 5
        assert not any(name.startswith("wall") for name in names)
        model = complex_room.environment.physics.model.ptr
        without = Obstacles.from_model(model, list(names))
        assert len(without.outlines) <= len(complex_room.environment.obstacles.outlines) - 5


def test_a_room_with_fewer_obstacles_gives_all_of_them() -> None:
    assert set(make_stage("task=nav_simple").setting.unmapped) == set(CENTRES)
    assert make_stage("task=nav_empty").setting.unmapped == ()


def test_an_obstacle_that_there_is_not_is_named_with_those_there_are() -> None:
    with pytest.raises(TaskError, match="no obstacle 'sofa'; it has east, north, south"):
        make_stage("task=nav_simple", "unmapped=[north,sofa]")


def test_five_targets_are_drawn_well_apart_on_free_floor(complex_room: Stage) -> None:
    config, environment = complex_room.config, complex_room.environment
    missions = [draw_mission(config, environment, number) for number in (1, 2, 3)]
    for mission in missions:
        assert len(mission.targets) == 5
        places = np.array([mission.start[:2], *mission.targets])
        assert np.hypot(*np.diff(places, axis=0).T).min() >= 2.0
        assert environment.obstacles.clearance(places).min() > 0.0
    assert len({mission.targets for mission in missions}) == 3
    assert missions[0] == draw_mission(config, environment, 1)


def test_start_and_targets_may_be_given() -> None:
    stage = make_stage("start=[0.5,-1,3]", "targets=[1,2,-3,0.5]")
    missions = [draw_mission(stage.config, stage.environment, number) for number in (1, 2)]
    for mission in missions:
        assert mission[:2] == ((0.5, -1.0, 3.0), ((1.0, 2.0), (-3.0, 0.5)))
    assert missions[0].seed != missions[1].seed, "their noise differs"


def test_a_given_target_that_is_not_free_is_refused() -> None:
    stage = make_stage("task=nav_simple", "targets=[3,3,0,1.2]")
    with pytest.raises(TaskError, match=r"a target must lie on free floor; at \(0, 1.2\) there is an obstacle"):
        draw_mission(stage.config, stage.environment, 1)
