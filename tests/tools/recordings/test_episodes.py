"""The list of recordings, and the table of their steps."""

import csv
import sys
from pathlib import Path
from typing import Any

import pytest

from asddpg.errors import UserError
from asddpg.recording.files.reading import open_recording
from tests.support.recordings import evaluated
from tools import episodes


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two recordings of nav_gazebo, two of nav_empty, a damaged one."""
    folder = tmp_path_factory.mktemp("runs")
    first, _ = evaluated(folder / "gazebo", "agent=controller", "task=nav_gazebo", "episodes=2")
    evaluated(folder / "empty", "agent=controller", "task=nav_empty", "episodes=2")
    (folder / "damaged.mcap").write_bytes(first.read_bytes()[:9000])
    return folder


def listed(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    capsys.readouterr()
    episodes.main([str(argument) for argument in arguments])
    return capsys.readouterr().out


def test_all_below_a_folder_are_listed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = listed(capsys, folder).splitlines()
    assert len(lines) == 1 + 4 + 1 + 1
    assert lines[-2].startswith("4 recordings, ")
    assert lines[-1].startswith("damaged: ")
    assert "tools.recover" in lines[-1]
    for path in folder.rglob("*/*.mcap"):
        (line,) = (line for line in lines if line.startswith(str(path.relative_to(folder))))
        recording = open_recording(path)
        outcome = recording.outcome()
        assert line.split()[1:4] == [recording.facts["task"], outcome["outcome"], str(outcome["steps"])]
        assert line.split()[4:6] == [f"{outcome['total_reward']:.2f}", "1.00"]


def test_filters(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "2 recordings" in listed(capsys, folder, "task=nav_gazebo")
    assert "no recording matches" in listed(capsys, folder, "min_steps=100000")
    outcomes = [open_recording(path).outcome()["outcome"] for path in folder.rglob("*/*.mcap")]
    assert f"{outcomes.count('crashed')} recording" in listed(capsys, folder, "outcome=crashed")
    assert "4 recordings" in listed(capsys, folder, "outcome=crashed,reached")


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_steps_are_exported(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    listed(capsys, folder, "task=nav_gazebo", f"export=steps.{kind}")
    steps = [(path, step) for path in sorted(folder.glob("gazebo/*/*.mcap")) for step in open_recording(path).steps()]
    if kind == "csv":
        with (tmp_path / "steps.csv").open(newline="") as file:
            rows: list[dict[str, Any]] = [
                {name: value or None for name, value in row.items()} for row in csv.DictReader(file)
            ]
    else:
        import pyarrow.parquet

        rows = pyarrow.parquet.read_table(tmp_path / "steps.parquet").to_pylist()
    assert len(rows) == len(steps)
    for row, (path, step) in zip(rows, steps, strict=True):
        assert row["file"] == str(path.relative_to(folder))
        assert float(row["action_omega"]) == step["action"]["omega"]
        assert float(row["terms_time"]) == step["terms"]["time"]
        assert int(row["digest"]) == step["digest"]
        assert row["noise_v"] is row["q_policy"] is None


def test_without_pyarrow_csv_is_left(folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(UserError, match="files need pyarrow, which is not installed: pip install .asddpg.parquet"):
        episodes.main([str(folder), f"export={tmp_path / 'steps.parquet'}"])
    episodes.main([str(folder), f"export={tmp_path / 'steps.csv'}"])
    assert (tmp_path / "steps.csv").is_file()


def test_invalid_arguments(folder: Path, tmp_path: Path) -> None:
    for arguments, sentence in (
        ([], "FOLDER is missing"),
        ([folder, "outcome=lost"], "outcome must be some of reached, crashed, timeout, cut, running"),
        ([folder, "outcome="], "no value"),
        ([folder, "task=nav_cellar"], "task must be nav_empty"),
        ([folder, "min_steps=-1"], "0 or more"),
        ([folder, "steps=3"], "there is no option 'steps'; did you mean min_steps"),
        ([folder, "export=steps.xls"], "must end in .csv or .parquet"),
        ([folder, "--export", "csv"], "name=value, such as export=…"),
        ([folder, "a", "b"], "at most, .*, not 3"),
        ([folder, f"export={tmp_path}/none/steps.csv"], "there is no folder"),
        ([folder, "min_steps=100000", f"export={tmp_path}/steps.csv"], "no step to export"),
        ([tmp_path / "nowhere"], "there is no folder"),
        ([tmp_path], "there are no recordings"),
    ):
        with pytest.raises(UserError, match=sentence):
            episodes.main([str(argument) for argument in arguments])
