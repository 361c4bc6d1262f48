"""Runs as CSV, written and read again as published ones."""

import csv
import shlex
from dataclasses import asdict
from pathlib import Path

import pytest
import yaml

from asddpg.command_line import train_config
from asddpg.config import TrainConfig
from asddpg.errors import UserError
from asddpg.options.parsing import flatten
from tests.support.fake_runs import finish_group
from tools import ablation, results
from tools.experiments.run_csv import PUBLISHED, read_csv, write_csv
from tools.experiments.run_store import RunStore
from tools.experiments.runs import WITHOUT_EFFECT, Group, digest

GROUP = Group("nav_empty", ("task=nav_empty",), 1000, (0, 1, 2))
DDPG = Group("DDPG", ("task=nav_empty", "agent=ddpg", "controller.gains=[2,1]"), 1000, (0,))
GROUPS = {"empty": GROUP, "ddpg": DDPG}


def written(folder: Path) -> Path:
    """The file of two runs of the first group and one of the second."""
    finish_group(folder / "runs", GROUP, [0.7, 0.8], model_hash="fedc")
    finish_group(folder / "runs", DDPG, [0.1])
    path = folder / "table.csv"
    write_csv(path, GROUPS, RunStore(folder / "runs").results(GROUPS))
    return path


def test_a_row_a_run_with_the_arguments_that_train_it_from_a_shell(tmp_path: Path) -> None:
    with written(tmp_path).open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["group"], row["seed"], row["success_last"]) for row in rows] == [
        ("empty", "0", "0.7"), ("empty", "1", "0.8"), ("ddpg", "0", "0.1"),
    ]  # fmt: skip
    assert rows[0]["arguments"].endswith("task=nav_empty seed=0")
    assert Path(rows[0]["folder"]) == tmp_path / "runs" / GROUP.run(0).name
    for row in rows:
        assert digest(asdict(train_config(shlex.split(row["arguments"])))) == row["digest"]


def test_published_runs_are_the_stored_ones_and_are_written_as_they_were_read(tmp_path: Path) -> None:
    path = written(tmp_path)
    published = RunStore(tmp_path / "nowhere", read_csv(path)).results(GROUPS)
    assert published == RunStore(tmp_path / "runs").results(GROUPS)
    assert published["ddpg"][0].metrics["share_1"] is None
    write_csv(tmp_path / "again.csv", GROUPS, published)
    assert (tmp_path / "again.csv").read_text() == path.read_text()


def test_a_damaged_file_is_one_sentence(tmp_path: Path) -> None:
    """Also one that is cut short anywhere in its header or its last row."""
    path = written(tmp_path)
    text = path.read_text().rstrip()
    header, last_row = text.index("\n"), text.rindex("\n") + 1
    damaged = [text[:end] for end in (*range(header), *range(last_row + 1, len(text)))]
    changes = ("success_last", "reach"), ("0.7,", "well,"), ("0.7,", "nan,"), ("task=nav_empty", "täsk")
    for content in (*damaged, *(text.replace(*change) for change in changes)):
        assert content != text
        path.write_text(content, encoding="latin-1")
        with pytest.raises(UserError, match=r"is not a whole table\.csv as these programs write it") as caught:
            read_csv(path)
        assert "\n" not in str(caught.value)
    path.unlink()
    with pytest.raises(UserError, match="there is no .* with published runs"):
        read_csv(path)


def test_the_ablation_trains_what_is_not_published(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(ablation, "TABLE", tmp_path / "published.csv")
    arguments = ["imitation", "seeds=100,101", "steps=1000", "rule_out=null"]
    grid = ablation.make_grid(*ablation.parse(arguments))
    finish_group(ablation.FOLDER, grid["default"], [0.9, 0.8])
    ablation.main(["table", *arguments])
    (ablation.FOLDER / "table.csv").rename(ablation.TABLE)
    ablation.FOLDER.rename("elsewhere")
    finish_group(ablation.FOLDER, grid["default_without_imitation"], [0.5])
    capsys.readouterr()
    ablation.main(["list", *arguments, "published"])
    listed = capsys.readouterr().out
    assert "default: default; seeds 100, 101; 2 of 2 finished" in listed
    assert "5 runs of 5000 steps in all to train" in listed
    assert "2 published runs stand in for runs of their options." in listed
    ablation.main(["table", *arguments, "published"])
    assert "| default without imitation (of 2, unfinished) | 100 | 0.500 | -0.400 |" in capsys.readouterr().out


def test_the_published_runs_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All of them, as the documents' tables show them."""
    monkeypatch.chdir(tmp_path)
    effect = "| default without imitation | 100, 101, 102 | 0.950, 0.880, 0.235 | -0.233 [-1.071, +0.604] |"
    of_a_run = "| nav_complex, sparse, 100k steps, one robot, seed 4 | 0.965 | 0.970 |"
    for program, row in ((results, of_a_run), (ablation, effect)):
        program.main(["table", "published"])
        text = (program.FOLDER / "table.md").read_text()
        assert row in text
        assert f"{len(read_csv(program.TABLE))} published runs stand in" in text
        assert (program.FOLDER / "table.csv").read_bytes() == program.TABLE.read_bytes()
    assert "missing" not in text
    store = RunStore(tmp_path / "nowhere", read_csv(results.TABLE))
    assert not store.missing(results.GROUPS)


def test_published_runs_were_trained_with_todays_defaults() -> None:
    """A digest does not show a default that changes: the runs that had the old one must then be trained again."""
    before = yaml.safe_load((PUBLISHED / "defaults.yaml").read_text(encoding="utf-8"))
    today = {n: value for n, value in flatten(asdict(TrainConfig())).items() if n.split(".")[0] not in WITHOUT_EFFECT}
    assert before == {name: today.get(name) for name in before}
