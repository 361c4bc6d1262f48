"""/map, /plan, /particles and /amcl_pose: of missions, of planners, and of none that plans."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from foxglove.messages import Grid
from mcap.records import Schema
from mcap_protobuf.decoder import DecoderFactory

from asddpg import mission, play
from asddpg.build import make_environment, navigation_env
from asddpg.command_line import train_config
from asddpg.drivers.room_map import draw_room_map
from asddpg.planning.navigation_view import NavigationView, PlanningDriver, view_plan
from asddpg.planning.navigator import Navigator, NavigatorOptions
from asddpg.planning.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from asddpg.recording.files.reading import open_recording
from asddpg.recording.messages.navigation_messages import MOST_PARTICLES, NavigationPublisher, map_message
from asddpg.recording.messages.topics import AMCL_POSE, MAP, PARTICLES, PLAN
from tasks.room_geometry.obstacles import Obstacles
from tests.support.fake_robot import FakeRobot, free_map, make_reading
from tests.support.recordings import evaluated

NAVIGATION = (MAP, PLAN, PARTICLES, AMCL_POSE)
TARGETS = ((0.8, 0.0), (0.8, 0.5))
Messages = dict[str, list[Any]]


def read_messages(folder: Path) -> Messages:
    """Of the only recording in a folder, by topic: times and contents."""
    (path,) = folder.iterdir()
    found: Messages = {}
    for message in open_recording(path).messages():
        found.setdefault(message.topic, []).append((message.time, message.content))
    return found


def cells_of(message: Any) -> np.ndarray:
    """Percent or −1, red, green, blue and alpha of each cell, (rows, columns, 5)."""
    names = [(field.name, field.offset) for field in message.fields]
    assert names == [("occupancy", 0), ("red", 1), ("green", 2), ("blue", 3), ("alpha", 4)]
    assert (message.cell_stride, message.row_stride) == (5, 5 * message.column_count)
    cells = np.frombuffer(message.data, dtype=np.uint8).reshape(-1, message.column_count, 5).astype(int)
    cells[..., 0] = cells[..., 0].astype(np.uint8).view(np.int8)
    return cells


def places(message: Any) -> np.ndarray:
    return np.array([(pose.position.x, pose.position.y) for pose in message.poses]).reshape(-1, 2)


def yaw_of(pose: Any) -> float:
    return 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)


# Messages -----------------------------------------------------------------------------------------------------------


def small_map() -> OccupancyGrid:
    return OccupancyGrid(np.array([[FREE, OCCUPIED, UNKNOWN], [70, 60, FREE]], dtype=np.int8), 0.5, (-1.0, 2.0))


def test_a_map_is_a_grid_with_percent_and_colour_in_each_cell() -> None:
    schema = Grid.get_schema()
    decode = DecoderFactory().decoder_for("protobuf", Schema(1, schema.data, schema.encoding, schema.name))
    assert decode is not None
    message = decode(map_message(small_map(), 1_500_000_000).encode())
    assert (message.column_count, message.cell_size.x, message.cell_size.y) == (3, 0.5, 0.5)
    assert (message.pose.position.x, message.pose.position.y) == (-1.0, 2.0)
    assert (message.timestamp.seconds, message.timestamp.nanos) == (1, 500_000_000)
    cells = cells_of(message)
    assert cells[..., 0].tolist() == small_map().cells.tolist()
    free, occupied, unknown = cells[0, :, 1:].tolist()
    assert occupied[3] > unknown[3] > free[3] == 0, "alpha: a free cell shows the floor"
    assert cells[1, :, 1:].tolist() == [occupied, free, free]


class Log(dict[str, Any]):
    """Takes messages, and counts them by topic."""

    def __init__(self) -> None:
        super().__init__({topic: lambda _, time, topic=topic: self.taken.append((topic, time)) for topic in NAVIGATION})
        self.taken: list[tuple[str, int]] = []

    def take(self) -> list[tuple[str, int]]:
        taken, self.taken = self.taken, []
        return taken


def test_what_has_not_changed_is_not_published_again_but_the_pose() -> None:
    log = Log()
    publisher = NavigationPublisher(log)
    view = NavigationView(small_map(), np.zeros((3, 2)), np.zeros((5, 3)), (0.0, 0.0, 0.0))
    publisher.publish(view, 1)
    assert log.take() == [(topic, 1) for topic in NAVIGATION]
    publisher.publish(view, 2)
    assert log.take() == [(AMCL_POSE, 2)]
    publisher.publish(view._replace(particles=np.ones((5, 3))), 3)
    assert log.take() == [(PARTICLES, 3), (AMCL_POSE, 3)]
    publisher.publish(view._replace(map=small_map(), particles=None, pose=None), 4)
    assert log.take() == [(MAP, 4)]
    publisher.begin()  # a viewer has come
    publisher.publish(view, 5)
    assert log.take() == [(topic, 5) for topic in NAVIGATION]


def test_a_plan_that_is_no_more_is_taken_away() -> None:
    log = Log()
    publisher = NavigationPublisher(log)
    publisher.publish(NavigationView(path=np.zeros((3, 2))), 1)
    publisher.publish(NavigationView(), 2)
    publisher.publish(NavigationView(), 3)
    assert log.take() == [(PLAN, 1), (PLAN, 2)]
    publisher.begin()  # an episode whose driver has no plan yet
    publisher.publish(NavigationView(), 4)
    assert log.take() == [(PLAN, 4)]


class Planner:
    """A driver with a global planner."""

    def __init__(self) -> None:
        self.navigator: Navigator | None = None


def test_a_view_is_that_of_the_navigator_if_there_is_one() -> None:
    assert view_plan(object()) == NavigationView()
    planner = Planner()
    assert isinstance(planner, PlanningDriver)
    assert view_plan(planner) == NavigationView()
    reading = make_reading((0.55, 2.05, 0.0), (3.55, 2.05))
    planner.navigator = Navigator(FakeRobot(free_map(), reading), NavigatorOptions(), reading)
    planner.navigator.update(reading)
    view = view_plan(planner)
    assert view.map is planner.navigator.map
    assert view.path is planner.navigator.path is not None
    assert (view.particles, view.pose) == (None, None)


# Missions -----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def of_mission(tmp_path_factory: pytest.TempPathFactory) -> Messages:
    out = tmp_path_factory.mktemp("mission")
    arguments = ["agent=move_base", "task=nav_simple", "start=[0,0,0]", "targets=[0.8,0,0.8,0.5]", "unmapped=[north]"]
    mission.main([*arguments, f"out={out}"])
    return read_messages(out / "missions/episodes")


def room(*without: str) -> OccupancyGrid:
    config = train_config(["task=nav_simple"])
    model = navigation_env(make_environment(config.task, config.reward)).physics.model.ptr
    return draw_room_map(Obstacles.from_model(model, without))


def test_the_recorded_map_is_the_one_that_lacks_the_obstacles(of_mission: Messages) -> None:
    ((time, message),) = of_mission[MAP]
    expected, complete = room("north"), room()
    found = cells_of(message)
    assert time == 0
    assert np.array_equal(found[..., 0], expected.cells)
    assert not np.array_equal(found[..., 0], complete.cells)
    assert (message.pose.position.x, message.pose.position.y) == expected.origin
    assert (message.cell_size.x, message.cell_size.y) == (expected.resolution, expected.resolution)
    assert message.frame_id == "world"


def test_each_plan_leads_from_the_robot_to_the_present_target(of_mission: Messages) -> None:
    plans = [(time, places(message)) for time, message in of_mission[PLAN] if message.poses]
    odometry = dict(of_mission["/odom"])
    ends = []
    for time, path in plans:
        pose = odometry[time].pose.position
        assert np.hypot(*(path - (pose.x, pose.y)).T).min() < 0.3, "it was made a step before"
        assert np.hypot(*np.diff(path, axis=0).T).max() < 0.3, "without a gap"
        ends.append(min(TARGETS, key=lambda target: math.dist(target, path[-1])))
        assert math.dist(path[-1], ends[-1]) < 1e-3
    assert ends == sorted(ends, key=TARGETS.index)
    assert set(ends) == set(TARGETS)


def test_the_points_of_a_plan_look_ahead(of_mission: Messages) -> None:
    message = next(message for _, message in of_mission[PLAN] if message.poses)
    points = places(message)
    directions = np.arctan2(*np.diff(points, axis=0).T[::-1])
    assert [yaw_of(pose) for pose in message.poses[:-1]] == pytest.approx(directions.tolist(), abs=1e-2)


def test_particles_lie_around_the_estimate_and_the_estimate_near_the_truth(of_mission: Messages) -> None:
    estimates = dict(of_mission[AMCL_POSE])
    assert set(estimates) == {time for time, _ in of_mission["/odom"]}, "one in each state"
    assert len(of_mission[PARTICLES]) > 3
    for time, message in of_mission[PARTICLES]:
        assert 10 < len(message.poses) <= MOST_PARTICLES
        place = estimates[time].pose.position
        assert math.dist(np.median(places(message), axis=0), (place.x, place.y)) < 0.15
    truth = {time: message.pose for time, message in of_mission["/odom"]}
    errors = [
        math.dist((found.pose.position.x, found.pose.position.y), (truth[time].position.x, truth[time].position.y))
        for time, found in estimates.items()
    ]
    assert max(errors) < 0.2
    assert max(errors) > 0.0, "it is an estimate"
    turns = [yaw_of(found.pose) - yaw_of(truth[time]) for time, found in estimates.items()]
    assert np.abs((np.array(turns) + math.pi) % (2 * math.pi) - math.pi).max() < 0.2


def test_goal_and_step_say_when_the_next_target_came(of_mission: Messages) -> None:
    goals = [(time, (message.pose.position.x, message.pose.position.y)) for time, message in of_mission["/goal"]]
    assert [place for _, place in goals] == list(TARGETS)
    assert 0 < goals[1][0] < of_mission["/odom"][-1][0]


# Planners without a mission -------------------------------------------------------------------------------------------


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_played_planner_shows_its_map_and_its_plans(here: Path) -> None:
    play.main(["agent=move_base", "task=nav_simple", "episodes=1", "seed=1"])
    found = read_messages(here / "played_episodes")
    assert not {PARTICLES, AMCL_POSE} & set(found), "it knows its pose"
    assert np.array_equal(cells_of(found[MAP][-1][1])[..., 0], room().cells)
    (goal,) = (message.pose.position for _, message in found["/goal"])
    ends = [places(message)[-1] for _, message in found[PLAN] if message.poses]
    assert len(ends) > 1
    assert all(math.dist(end, (goal.x, goal.y)) < 1e-3 for end in ends)


def test_a_map_that_is_built_shows_what_was_seen(here: Path) -> None:
    arguments = ["agent=move_base", "task=nav_simple", "planner.map=built", "episodes=1", "seed=1"]
    play.main(arguments)
    maps = read_messages(here / "played_episodes")[MAP]
    first, last = (cells_of(maps[index][1])[..., 0] for index in (0, -1))
    assert len(maps) > 2
    known = [int((cells_of(message)[..., 0] != UNKNOWN).sum()) for _, message in maps]
    assert 0 < known[0] < known[-1]
    assert known == sorted(known)
    assert (first == UNKNOWN).any()
    # What it takes for occupied is: the nearest obstacle on the room's map lies within two cells.
    message, truth = maps[-1][1], room()
    rows, columns = np.nonzero(last >= 65)
    assert len(rows) > 10
    origin = np.array([message.pose.position.x, message.pose.position.y])
    hits = (np.stack([columns, rows], axis=1) + 0.5) * message.cell_size.x + origin
    obstacles = truth.to_points(np.argwhere(truth.occupied))
    nearest = np.hypot(*(hits[:, None] - obstacles[None]).transpose(2, 0, 1)).min(axis=1)
    assert np.quantile(nearest, 0.95) < 0.1


def test_a_mission_may_build_its_planners_map(here: Path) -> None:
    arguments = ["agent=move_base", "task=nav_simple", "start=[0,0,0]", "targets=[0.6,0]", "unmapped=[north]"]
    mission.main([*arguments, "planner.map=built"])
    _, message = read_messages(here / "missions/episodes")[MAP][-1]
    cells = cells_of(message)[..., 0]
    assert (cells == UNKNOWN).any()
    assert (cells >= 65).any()


def test_an_evaluated_planner_shows_them_too_and_others_have_no_such_topics(tmp_path: Path) -> None:
    planned, led, alone = (
        evaluated(tmp_path / agent, f"agent={agent}", "task=nav_empty", "episodes=1")[0].parent
        for agent in ("move_base", "waypoints", "controller")
    )
    for folder, topics in ((planned, {MAP, PLAN}), (led, {MAP, PLAN}), (alone, set())):
        assert set(NAVIGATION) & set(read_messages(folder)) == topics
    data = next(alone.iterdir()).read_bytes()
    assert b"/map" not in data, "without messages, a channel would be there yet"
    assert b"/map" in next(planned.iterdir()).read_bytes()
