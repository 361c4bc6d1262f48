"""Drivers side by side: the same pairs for all, nothing driven twice, nothing overwritten, errors in a sentence."""

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from asddpg import evaluate
from asddpg.errors import UserError
from tests.conftest import ROOT
from tests.support import own_driver
from tests.support.room_files import write_maze
from tools import compare
from tools.comparison.driven_episodes import DrivenCase

FORWARD, FRAGILE = "tests.support.own_driver:Forward", "tests.support.own_driver:Fragile"


def compared(folder: Path, drivers: str, *arguments: str, episodes: int = 2, processes: int = 1) -> dict[str, Path]:
    """Compare drivers, such as [controller,random]; the files that are there then, by name without digest."""
    given = [f"drivers={drivers}", f"episodes={episodes}", f"processes={processes}", f"folder={folder}", *arguments]
    compare.main(["tasks=[nav_empty]", *given])
    return {path.stem.rpartition("_")[0]: path for path in folder.glob("*.json")}


def rows(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of two drivers compared; to be read, not written to."""
    folder = tmp_path_factory.mktemp("compare")
    compared(folder, f"[controller,{FORWARD}]")
    return folder


def test_all_drive_the_same_stored_pairs_with_the_figures_of_an_evaluation(folder: Path, tmp_path: Path) -> None:
    controller, forward = (DrivenCase.read(path) for path in sorted(folder.glob("*.json")))
    assert (controller.driver, forward.driver) == ("controller", FORWARD)
    assert [each.pair for each in controller.episodes] == [each.pair for each in forward.episodes]
    assert len({each.pair for each in controller.episodes}) == 2
    assert forward.episodes[0].smoothness.total_change == 0.0 < controller.episodes[0].smoothness.total_change
    assert 0.0 < controller.decision_ms < 50.0
    evaluate.main(["agent=controller", "task=nav_empty", "episodes=2", f"out={tmp_path}"])
    expected, row = json.loads((tmp_path / "evaluation.json").read_text()), rows(folder / "table.csv")[0]
    for name in ("success_rate", "metric", "mean_time", "spl"):
        found = [float(row[f"{name}{end}"]) for end in ("", "_low", "_high")]
        assert found == pytest.approx([expected[name]["value"], *expected[name]["ci95"]])


def test_the_tables_have_a_row_a_driver_and_the_differences_to_the_baseline(folder: Path) -> None:
    table = (folder / "table.md").read_text()
    assert "| controller | nav_empty | 2 | 1.000 [0.342, 1.000] | 0.000" in table
    assert "The driver less controller, paired by start and goal" in table
    assert f"task.min_linear_velocity differs: 0.05 of controller, 0.0 of {FORWARD}." in table
    (difference,) = rows(folder / "differences.csv")
    assert (difference["driver"], difference["pairs"]) == (FORWARD, "2")


def test_a_finished_one_is_not_driven_again_and_another_option_is_another_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drivers = f"[controller,{FORWARD}]"
    before = compared(tmp_path, drivers)
    content = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with monkeypatch.context() as patched:
        patched.setattr("tools.comparison.worker_processes.drive", None)
        assert compared(tmp_path, drivers) == before
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == content
    compared(tmp_path, drivers, "controller.gains=[0.5,1]")  # which the other driver does not heed
    assert len(list(tmp_path.glob("controller_*.json"))) == 2
    assert len(list(tmp_path.glob("tests*.json"))) == 1
    compared(tmp_path, drivers, episodes=1)
    assert len(list(tmp_path.glob("*.json"))) == 5
    assert all(path.read_bytes() == old for path, old in content.items() if path.suffix == ".json")
    assert (tmp_path / "table_1.md").read_bytes() == content[tmp_path / "table.md"]


def test_what_is_missing_is_driven_and_a_changed_driver_of_ones_own_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    files = compared(tmp_path, f"[controller,{FORWARD}]")
    files["controller_nav_empty"].unlink()
    compared(tmp_path, f"[controller,{FORWARD}]")
    assert capsys.readouterr().out.count("1 of 2 to drive") == 1
    monkeypatch.setattr(own_driver.Forward, "identity", "other weights", raising=False)
    compared(tmp_path, f"[{FORWARD}]")
    assert len(list(tmp_path.glob("tests*.json"))) == 2


def test_a_run_and_a_policy_with_and_without_a_planner(tiny_run: Path, tmp_path: Path) -> None:
    drivers = f"[pretrained:nav_empty,pretrained:nav_empty+waypoints,{tiny_run},waypoints]"
    files = compared(tmp_path, drivers, "planner.look_ahead=2", "baseline=waypoints", episodes=1)
    cases = [DrivenCase.read(path) for path in files.values()]
    options = {case.driver: case.conditions["options"].get("planner") for case in cases}
    planner = {"map": "known", "look_ahead": 2.0}
    assert options.pop(str(tiny_run)) is None
    assert options == {
        "pretrained:nav_empty": None,
        "pretrained:nav_empty+waypoints": planner,
        "waypoints": planner,
    }
    assert [row["driver"] for row in rows(tmp_path / "differences.csv")] == [
        "pretrained:nav_empty",
        "pretrained:nav_empty+waypoints",
        str(tiny_run),
    ]
    assert not (tiny_run / "evaluation.json").exists()


@pytest.mark.slow
def test_two_processes_drive_what_one_does(folder: Path, tmp_path: Path) -> None:
    compared(tmp_path, f"[controller,{FORWARD}]", processes=2)
    for path in folder.glob("*.json"):
        found, expected = DrivenCase.read(tmp_path / path.name), DrivenCase.read(path)
        assert found.conditions == expected.conditions
        assert [each.episode for each in found.episodes] == [each.episode for each in expected.episodes]


@pytest.mark.slow
def test_a_driver_that_fails_in_a_process_ends_the_program_in_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=rf"{FRAGILE} on nav_empty was not driven: its process ended with status 7"):
        compared(tmp_path, f"[move_base,{FRAGILE}]", processes=2, episodes=200)
    broken = "tests.support.own_driver:Broken"
    with pytest.raises(UserError, match="Broken on nav_empty was not driven: the driver .* must give v and ω"):
        compared(tmp_path, f"[move_base,{broken}]", processes=2, episodes=200)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_an_interrupt_ends_it_cleanly(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "tools.compare", "drivers=[move_base,waypoints]", f"folder={tmp_path}"]
    program = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert program.stdout is not None
    assert "2 of 2 to drive" in program.stdout.readline()
    time.sleep(3.0)
    program.send_signal(signal.SIGINT)
    _, said = program.communicate(timeout=30)
    assert (program.returncode, said) == (130, "stopped\n")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["drivers=[contoller]"], "there is no driver 'contoller'; there are controller, random, move_base"),
        (["drivers=[controller+waypoints]"], "there is no driver 'controller.waypoints'"),
        (["drivers=[controller,nowhere:Driver]"], "there is no driver 'nowhere:Driver'"),
        (["drivers=[pretrained:nothing]"], "there is no pretrained policy 'nothing'"),
        (["drivers=[controller,controller]"], "drivers must be one driver or more, each once"),
        (["drivers=[]"], "drivers must be one driver or more"),
        ([], "drivers= is missing"),
        (["drivers=[controller]", "tasks=[nav_moon]"], "tasks must be one or more of nav_empty, .*, not .*nav_moon"),
        (["drivers=[controller]", "episodes=1001"], "episodes must be from 1 to 1000, the size of the stored test set"),
        (["drivers=[controller]", "baseline=random"], "baseline must be one of drivers, controller, not 'random'"),
        (["drivers=[random]", "controller.gains=[2,1]"], "controller.gains is for the drivers controller and"),
        (["drivers=[controller]", "planner.map=built"], r"planner.\* is for move_base"),
        (["drivers=[controller]", "folder=a_file/below"], "the folder a_file/below cannot be made"),
        (["drivers=[empty]"], "empty"),
    ],
)
def test_a_mistake_is_one_sentence_and_nothing_is_driven(
    arguments: list[str], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a_file").touch()
    (tmp_path / "empty").mkdir()
    with pytest.raises(UserError, match=sentence):
        compare.main(arguments)
    assert not list(tmp_path.rglob("*.json"))


def test_a_damaged_file_is_named_and_not_counted(tmp_path: Path) -> None:
    (path,) = compared(tmp_path, f"[{FORWARD}]", episodes=1).values()
    for damaged in ("{", "[]", '{"episodes": []}', json.dumps(json.loads(path.read_text()) | {"episodes": []})):
        path.write_text(damaged)
        with pytest.raises(UserError, match=rf"{path.name} is not a whole file of tools\.compare"):
            compared(tmp_path, f"[{FORWARD}]", episodes=1)


def test_several_generated_rooms_are_one_row_and_paired_by_room(tmp_path: Path) -> None:
    arguments = [f"drivers=[controller,{FORWARD}]", "tasks=[cylinders:0-1]", "episodes=2", "processes=1"]
    compare.main([*arguments, f"folder={tmp_path}"])
    controller, forward = (DrivenCase.read(path) for path in sorted(tmp_path.glob("*.json")))
    assert controller.task == "cylinders:0-1"
    assert [each.room for each in controller.episodes] == ["cylinders:0", "cylinders:1"]  # a pair of its own each
    assert [each.pair for each in controller.episodes] == [each.pair for each in forward.episodes]
    assert [(row["driver"], row["task"], row["episodes"]) for row in rows(tmp_path / "table.csv")] == [
        ("controller", "cylinders:0-1", "2"),
        (FORWARD, "cylinders:0-1", "2"),
    ]
    (difference,) = rows(tmp_path / "differences.csv")
    assert difference["pairs"] == "2"


def test_a_run_and_a_baseline_are_paired_in_a_room_by_a_relative_path(
    tiny_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments = [f"drivers=[controller,{tiny_run}]", f"tasks=[{write_maze(tmp_path)}]", "episodes=2", "processes=1"]
    compare.main([*arguments, "folder=compared"])
    (difference,) = rows(tmp_path / "compared/differences.csv")
    assert (difference["task"], difference["pairs"]) == (str(tmp_path / "maze.txt"), "2")
    assert len(list(tmp_path.glob("compared/*_maze_*.json"))) == 2


@pytest.mark.parametrize("task", ["cylinders:0-1000", "cylinders:5-3", "nothing:0-3", "none.txt:0-3"])
def test_rooms_that_are_too_many_or_none_are_refused(task: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"tasks must be .* or up to 1000 of them such as cylinders:0-49, not"):
        compare.main(["drivers=[controller]", f"tasks=[{task}]", f"folder={tmp_path}"])
