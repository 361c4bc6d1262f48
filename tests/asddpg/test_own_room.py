"""Rooms of one's own, by the documented commands in an empty folder."""

import json
import re
import shutil
from pathlib import Path

import gymnasium
import numpy as np
import pytest
import yaml

from asddpg import evaluate, mission, play, train
from asddpg.config import MissionConfig
from asddpg.errors import UserError
from asddpg.missions.setting import MissionSetting, _draw_unmapped
from tasks import ALL_TASKS
from tasks.errors import TaskError
from tasks.registry import task_model
from tests.support.entry_point import ended
from tests.support.hostile_rooms import STILL_ROOMS, write_hostile
from tests.support.room_files import FORMATS, QUICK_TRAINING, write_maze, write_picture, write_world


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run in a Gazebo world, which lies beside it; to be copied, not written to."""
    folder = tmp_path_factory.mktemp("own_room")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        train.main([f"task={write_world(folder)}", *QUICK_TRAINING, "run_dir=run"])
    return folder


@pytest.fixture
def run(trained: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of that run in a folder of its own, which is the present one; the room stays where it was."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copytree(trained / "run", "copied"))


def evaluation(folder: Path) -> dict[str, object]:
    content: dict[str, object] = json.loads((folder / "evaluation.json").read_text())
    return content


@pytest.mark.parametrize("form", FORMATS)
def test_a_room_of_each_format_is_evaluated_and_played_in(
    form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    room = FORMATS[form](tmp_path)
    evaluate.main(["agent=controller", f"task={room}", "episodes=2"])
    assert evaluation(tmp_path)["set"] == "2 test pairs of the room"
    play.main(["agent=controller", f"task={room}", "episodes=1", "seed=1"])
    assert "episode 1: " in capsys.readouterr().out
    with gymnasium.make("asddpg/Nav-v0", scene=room) as env:
        _, info = env.reset(seed=0)
        assert info["outcome"] == "running"


def test_a_training_keeps_its_room_by_an_absolute_path_and_its_evaluation_sets(trained: Path) -> None:
    config = yaml.safe_load((trained / "run/config.yaml").read_text())
    assert config["task"]["name"] == str(trained / "room.world")
    assert config["task"]["min_linear_velocity"] == 0.05
    assert config["reward"]["progress"] == 0.0  # sparse
    tested, pairs = (json.loads((trained / f"run/{name}.json").read_text()) for name in ("test", "pairs"))
    assert tested["last"]["episodes"] == 2
    assert len(pairs["test"]) > len(pairs["validation"]) > 0
    assert all(pair["shortest_path"] > 0.5 for pair in pairs["test"] + pairs["validation"])


def test_a_run_is_evaluated_and_played_from_another_folder(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tasks.evaluation_pairs.find_paths", None)  # its pairs are kept
    evaluate.main([f"run={run}", "episodes=3"])
    assert evaluation(run)["set"] == "3 test pairs of the room"
    play.main([f"run={run}", "episodes=1", "seed=1"])


def test_a_policy_trained_in_a_room_drives_in_another(run: Path, tmp_path: Path) -> None:
    evaluate.main([f"run={run}", f"task={write_maze(tmp_path)}", "episodes=1"])
    assert evaluation(run)["task"] == str(tmp_path / "maze.txt")
    evaluate.main([f"run={run}", "task=nav_simple", "episodes=1"])
    assert evaluation(run)["set"] == "1 stored test pairs"


def test_a_room_that_was_moved_away_is_named_and_another_path_helps(
    run: Path, trained: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (trained / "room.world").rename(tmp_path / "moved.world")
    try:
        for program in (evaluate.main, play.main):
            with pytest.raises(TaskError, match=f"there is no file {trained / 'room.world'}"):
                program([f"run={run}", "episodes=1"])
        monkeypatch.setattr("tasks.evaluation_pairs.find_paths", None)  # the same room has the same pairs
        evaluate.main([f"run={run}", "episodes=1", "task=moved.world"])
    finally:
        (tmp_path / "moved.world").rename(trained / "room.world")


@pytest.mark.parametrize("content", ["", "{", "[]", '{"room": 1}', "[" * 100_000, '"shortest_path": "far"', ": NaN"])
def test_damaged_pairs_of_a_run_are_searched_again(run: Path, content: str) -> None:
    file = run / "pairs.json"
    kept = file.read_text()
    damage = {
        '"': re.sub(r'"shortest_path": [0-9.]+', content, kept),
        ":": re.sub(r": [0-9.]+$", content, kept, flags=re.M),
    }
    file.write_text(damage.get(content[:1], content))
    evaluate.main([f"run={run}", "episodes=1"])
    assert evaluation(run)["set"] == "1 test pair of the room"


def test_what_a_room_lacks_of_its_file_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    world = tmp_path / write_world(tmp_path)
    unread = "<include><uri>model://statue</uri></include><actor name='walker'/></world>"
    world.write_text(world.read_text().replace("</world>", unread))
    evaluate.main(["agent=controller", "task=room.world", "episodes=1"])
    said = capsys.readouterr().out.splitlines()[0]
    assert re.fullmatch(rf"note: of {world} was not taken: .*; python -m tools.room names 1 more", said)


def test_the_seeds_of_a_room_give_fresh_pairs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    evaluate.main(["agent=controller", f"task={write_maze(tmp_path)}", "episodes=2", "seed=4"])
    assert evaluation(tmp_path)["set"] == "2 fresh pairs, seed 4"


def test_a_mission_in_a_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    targets = "targets=[3.2,0.8]"
    mission.main(["agent=move_base", f"task={write_world(tmp_path)}", "start=[0.8,0.8,0]", targets, "unmapped=[post]"])
    (row,) = (tmp_path / "missions/missions.csv").read_text().splitlines()[1:]
    assert row.startswith("1,")
    assert (tmp_path / "missions/mission_01.png").is_file()


def test_a_mission_leaves_walls_and_fence_on_the_map_and_single_obstacles_out(tmp_path: Path) -> None:
    for room in ("open:3", str(tmp_path / FORMATS["irsim"](tmp_path))):
        model = task_model(room)
        names = {name for seed in range(5) for name in _draw_unmapped(seed, model)}
        assert names == {{"open:3": "box"}.get(room, "obstacle_1")}
    setting = MissionSetting(MissionConfig(unmapped=["cylinder_1"]))
    env = gymnasium.make("asddpg/Nav-v0", scene="cylinders:1").unwrapped
    setting.make_robot(env)  # type: ignore[arg-type]
    assert len(setting.known.outlines) == len(env.obstacles.outlines) - 1  # type: ignore[attr-defined]


def test_make_vec_gives_robots_in_a_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scene = write_picture(tmp_path)
    envs = gymnasium.make_vec("asddpg/Nav-v0", num_envs=3, scene=scene)
    _, info = envs.reset(seed=5)
    for robot in range(3):
        with gymnasium.make("asddpg/Nav-v0", scene=scene) as env:
            assert env.reset(seed=5 + robot)[1]["start"] == pytest.approx(info["start"][robot])
    for _ in range(5):
        envs.step(np.tile(np.array([0.2, 0.1], np.float32), (3, 1)))
    envs.close()
    with gymnasium.make(gymnasium.make("asddpg/Nav-v0", scene=scene).spec) as env:  # type: ignore[arg-type]
        assert env.unwrapped._task_name == scene  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("task", "sentence"),
    [
        ("foo", f"there is no task 'foo'; there are {', '.join(ALL_TASKS)}, or a file of a room (.xml, "),
        ("cylinders:x", "there is no task 'cylinders:x'; there are"),
        ("nav_complx", "there is no task 'nav_complx'; did you mean nav_complex?"),
        ("nothing:3", "there is no task 'nothing:3'; there are"),
        ("foo.world", "there is no file "),
        ("full.world", "full.world is no file"),
        ("plan.png", "plan.png is a picture: the metres of a pixel stand behind it, such as "),
        ("plan.png@0", "the metres a pixel must be from 0.0001 to 500, not 0"),
        ("plan.png@1e", "the metres of a pixel stand behind it"),
    ],
)
@pytest.mark.parametrize("program", [train.main, evaluate.main])
def test_a_wrong_name_of_a_room_is_one_sentence(
    program: object, task: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_picture(tmp_path)
    (tmp_path / "full.world").mkdir()
    arguments = [] if program is train.main else ["agent=controller"]
    with pytest.raises((UserError, TaskError)) as caught:
        program([*arguments, f"task={task}"])  # type: ignore[operator]
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["full.world", "plan.png"]


@pytest.mark.parametrize("scene", ["", "nav_empty", "foo", "plan.png\0", "a\0.xml", None, 3])
def test_gymnasium_needs_a_scene(scene: object) -> None:
    for make in (gymnasium.make, gymnasium.make_vec):
        with pytest.raises(TaskError, match=r"asddpg/Nav-v0 needs scene=, a file of a room|cannot be read"):
            make("asddpg/Nav-v0", scene=scene)
    with pytest.raises(TaskError, match=r"not ''"):
        gymnasium.make("asddpg/Nav-v0")


def test_a_wrong_room_ends_a_program_with_status_2() -> None:
    for main, arguments in ((train.main, []), (play.main, ["agent=controller"])):
        found = ended(main, [*arguments, "task=foo.world"])
        assert (found.status, found.made) == (2, [])
        assert found.said.startswith("error: there is no file ")
        assert found.said.count("\n") == 1


def test_30_hostile_files_end_a_program_with_status_2(tmp_path: Path) -> None:
    chosen = [name for name in write_hostile(tmp_path) if not Path(name).name.startswith(STILL_ROOMS)]
    for name in chosen[:: len(chosen) // 30][:30]:
        found = ended(evaluate.main, ["agent=controller", f"task={name}", "episodes=1"])
        assert (found.status, found.made) == (2, []), name
        assert found.said.startswith("error: "), name
        assert found.said.count("\n") == 1, name
