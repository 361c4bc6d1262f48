"""Runs as CSV, written and read again as published ones."""

import csv
from pathlib import Path

import pytest

from asddpg.errors import UserError
from tests.support.fake_runs import finish_group
from tools import ablation, results, stamp_published
from tools.experiments import run_csv
from tools.experiments.run_csv import digest, outdated, published_runs, write_csv
from tools.experiments.run_grid import known_runs, results_of
from tools.experiments.run_groups import Group, finished
from tools.experiments.run_metrics import read_run_metrics
from tools.experiments.run_provenance import provenance
from tools.experiments.run_store import stored_runs

GROUP = Group("nav_empty", ("task=nav_empty",), 1000, (0, 1, 2))
DDPG = Group("DDPG", ("task=nav_empty", "agent=ddpg"), 1000, (0,))
GROUPS = {"empty": GROUP, "ddpg": DDPG}


def written(folder: Path) -> Path:
    """The file of two runs of the first group and one of the second."""
    finish_group(folder / "runs", "empty", GROUP, [0.7, 0.8], model_hash="fedc")
    finish_group(folder / "runs", "ddpg", DDPG, [0.1])
    path = folder / "table.csv"
    write_csv(path, GROUPS, results_of(GROUPS, stored_runs(folder / "runs")))
    return path


def test_a_row_a_run_with_the_words_that_train_it(tmp_path: Path) -> None:
    with written(tmp_path).open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["group"], row["seed"], row["success_last"]) for row in rows] == [
        ("empty", "0", "0.7"), ("empty", "1", "0.8"), ("ddpg", "0", "0.1"),
    ]  # fmt: skip
    assert rows[0]["arguments"].endswith("task=nav_empty seed=0")
    assert Path(rows[0]["folder"]) == tmp_path / "runs/empty_seed0"


def test_published_runs_have_the_figures_that_the_stored_ones_had(tmp_path: Path) -> None:
    path = written(tmp_path)
    stored = finished(GROUPS, stored_runs(tmp_path / "runs"))
    published = finished(GROUPS, published_runs(path, GROUPS))
    for name, runs in stored.items():
        assert [read_run_metrics(run) for run in runs] == [run.metrics for run in published[name]]
        assert [run.settings for run in runs] == [run.settings for run in published[name]]
        assert [dict(run.provenance) for run in runs] == [dict(run.provenance) for run in published[name]]
    assert published["ddpg"][0].metrics.share_1 is None


def test_a_run_serves_whoever_asks_for_its_options_and_nobody_else(tmp_path: Path) -> None:
    path = written(tmp_path)
    same = Group("the same by another name", ("task=nav_empty", "agent.imitation=1"), 1000, (0,))
    other = Group("another", ("task=nav_empty", "agent.imitation=0.5"), 1000, (0,))
    found = finished({"same": same, "other": other}, published_runs(path, {"same": same, "other": other}))
    assert [run.metrics.success_last for run in found["same"]] == [0.7]
    assert not found["other"]


@pytest.mark.parametrize(
    "change",
    [
        ("success_last", "reach"),
        ("0.7,", "well,"),
        ("0.7,", "nan,"),
        ("options_digest", "digest"),
        ("task=nav_empty seed=1", '"task=nav_empty seed=1'),
        ("task=nav_empty seed=1", "task='nav_empty seed=1"),
        ("task=nav_empty", "täsk"),
    ],
)
def test_a_damaged_file_is_one_sentence(change: tuple[str, str], tmp_path: Path) -> None:
    path = written(tmp_path)
    text = path.read_text()
    assert change[0] in text
    path.write_text(text.replace(*change), encoding="latin-1")
    for read in (outdated, lambda path: published_runs(path, GROUPS)):
        with pytest.raises(UserError, match="is not a whole table.csv as these programs write it") as caught:
            read(path)
        assert "\n" not in str(caught.value)


def test_a_file_cut_short_anywhere_in_its_header_or_last_row_is_one_sentence(tmp_path: Path) -> None:
    path = written(tmp_path)
    text = path.read_text().rstrip()
    header, last_row = text.index("\n"), text.rindex("\n") + 1
    for end in (*range(header), *range(last_row + 1, len(text))):
        path.write_text(text[:end])
        with pytest.raises(UserError, match="is not a whole table.csv"):
            outdated(path)


def test_no_file_is_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    with pytest.raises(UserError, match="there is no .* with published runs"):
        published_runs(path, GROUPS)


def test_published_runs_are_written_as_they_were_read(tmp_path: Path) -> None:
    path = written(tmp_path)
    again = tmp_path / "again.csv"
    known = known_runs(GROUPS, tmp_path / "nowhere", path)
    write_csv(again, GROUPS, results_of(GROUPS, known))
    assert again.read_text() == path.read_text()
    assert provenance(results_of(GROUPS, known)) == provenance(results_of(GROUPS, stored_runs(tmp_path / "runs")))


def test_runs_of_before_a_new_option_are_stamped_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path)
    right = path.read_text()
    old = digest(GROUP.settings(1))
    path.write_text(right.replace(old, "0123456789abcdef"))
    monkeypatch.setattr(run_csv, "PUBLISHED", tmp_path)
    stamp_published.main([])
    assert "table.csv: 1 runs of other options" in capsys.readouterr().out
    assert path.read_text() == right
    path.write_text(right.replace("agent=ddpg", "agent=gone"))
    with pytest.raises(UserError, match="there is no agent 'gone'"):
        stamp_published.main([])
    with pytest.raises(UserError, match="takes no words"):
        stamp_published.main(["all"])


def test_the_ablation_trains_what_is_not_published(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(ablation, "TABLE", tmp_path / "published.csv")
    arguments = ["imitation", "seeds=100,101", "steps=1000", "rule_out=none"]
    grid = ablation.rows(ablation.request(arguments))
    finish_group(ablation.FOLDER, "default", grid["default"].group, [0.9, 0.8])
    ablation.main(["table", *arguments])
    (ablation.FOLDER / "table.csv").rename(ablation.TABLE)
    ablation.FOLDER.rename("elsewhere")
    finish_group(ablation.FOLDER, "default_without_imitation", grid["default_without_imitation"].group, [0.5])
    capsys.readouterr()
    ablation.main(["list", *arguments, "published"])
    listed = capsys.readouterr().out
    assert "default: default; seeds 100, 101; 2 of 2 finished" in listed
    assert "5 runs of 5000 steps in all to train" in listed
    ablation.main(["table", *arguments, "published"])
    assert "| default without imitation (of 2, unfinished) | 100 | 0.500 | -0.400 |" in capsys.readouterr().out
    ablation.main(["list", *arguments])
    assert "7 runs" in capsys.readouterr().out


def test_runs_whose_words_mean_other_options_today_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A default may have changed since, or an option be gone; what is trained with them now is another experiment."""
    path = written(tmp_path)
    assert outdated(path) == 0
    changed = path.read_text().replace("task=nav_empty seed=0", "task=nav_empty agent.gone=1 seed=0")
    path.write_text(changed.replace("agent=ddpg", "agent=asddpg"))
    assert outdated(path) == 2
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(ablation, "TABLE", path)
    ablation.main(["table", "imitation", "published"])
    assert "2 serve nobody: today their words mean other options." in capsys.readouterr().out


def test_the_published_runs_are_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After a new option that changes nothing: python -m tools.stamp_published; after any other change: train anew."""
    assert all(finished(results.GROUPS, published_runs(results.TABLE, results.GROUPS)).values())
    assert outdated(results.TABLE) == outdated(ablation.TABLE) == 0
    monkeypatch.chdir(tmp_path)
    results.main(["table", "published", "complex"])
    text = (results.FOLDER / "table.md").read_text()
    assert "| nav_complex, sparse, 100k steps, seed 4 | 0.965 | 0.970 |" in text
    assert "The controller alone has not been driven here yet" in text
