"""Which runs are finished, which would be trained, and which are no longer the ones of their options."""

from dataclasses import asdict
from pathlib import Path

import pytest

from asddpg.errors import UserError
from asddpg.runs.lock import RunLock
from asddpg.runs.provenance import versions
from tests.support.fake_runs import finish, finish_group
from tools.experiments.run_store import RunStore, archive_existing, can_resume
from tools.experiments.runs import Group, differences, digest

DEFAULT = Group("default", ("task=nav_empty",), 1000, (0, 1, 2))
WIDTHS = Group("fc3x256", ("task=nav_empty", "network=fc3x256"), 1000, (0, 1))
SMALL = Group("fc2x100", ("task=nav_empty", "network=fc2x100"), 1000, (0,))
GROUPS = {"default": DEFAULT, "widths": WIDTHS, "small": SMALL}
RUN = DEFAULT.run(0)


def test_a_runs_folder_is_named_by_what_differs_from_the_defaults() -> None:
    options = asdict(RUN.config)
    assert RUN.name == f"nav_empty_asddpg_seed0_{digest(options)}"
    assert differences(options) == {
        "task.name": "nav_empty",
        "task.min_linear_velocity": 0.05,
        "reward.name": "dense",
        "reward.progress": 1.0,
        "reward.time_penalty": 0.01,
        "total_steps": 1000,
        "validation.every": 50,
    }


def test_neither_an_option_that_is_off_by_default_nor_one_that_does_not_bear_on_learning_changes_a_digest() -> None:
    """As a run of before the option lacks it; one that is gone since, or has a changed default, makes another run."""
    lacking = asdict(RUN.config)
    del lacking["agent"]["twin_critics"]
    assert digest(lacking) == RUN.digest
    assert digest(lacking | {"gone": 1}) != RUN.digest
    old_default = lacking | {"agent": lacking["agent"] | {"gamma": 0.95}}
    assert digest(old_default) != RUN.digest
    without_effect = ("record.every=0", "live=true", "port=0", "speed=2", "checkpoint_every=5", "run_dir=x")
    assert Group("", (*DEFAULT.arguments, *without_effect), 1000, (0,)).digest == DEFAULT.digest


def test_a_finished_run_serves_every_group_that_asks_for_it(tmp_path: Path) -> None:
    finish_group(tmp_path, WIDTHS, [0.5, 0.6])
    store = RunStore(tmp_path)
    runs = store.missing(GROUPS)
    assert [run.title for run in runs] == ["default, seed 2", "fc2x100, seed 0"]
    assert runs[0].arguments == ("total_steps=1000", "validation.every=50", "task=nav_empty", "seed=2")
    found = store.results(GROUPS)
    assert list(found["default"]) == [0, 1]
    assert found["default"] == found["widths"]
    assert not found["small"]


@pytest.mark.parametrize("lacking", ["resources.json", "config.yaml"])
def test_an_interrupted_run_is_not_finished(lacking: str, tmp_path: Path) -> None:
    (finish(tmp_path, RUN) / lacking).unlink()
    assert not RunStore(tmp_path).find(RUN)


@pytest.mark.parametrize("text", ["", "- 1", "{", "task: {name: nav_empty}", "2020-01-01: 2020-01-01\nprovenance: {}"])
def test_a_run_whose_configuration_is_damaged_serves_nobody(text: str, tmp_path: Path) -> None:
    (finish(tmp_path, RUN) / "config.yaml").write_text(text)
    assert not RunStore(tmp_path).find(RUN)


@pytest.mark.parametrize("note", ["prolonged", "resumed"])
def test_a_run_that_was_prolonged_or_resumed_elsewhere_is_not_the_experiment_of_its_options(
    note: str, tmp_path: Path
) -> None:
    path = finish(tmp_path, RUN, provenance={note: "at step 500"})
    assert not RunStore(tmp_path).find(RUN)
    (path / "resources.json").unlink()
    assert not can_resume(RUN, path)


def test_only_an_unfinished_run_of_the_same_options_and_versions_goes_on(tmp_path: Path) -> None:
    path = finish(tmp_path, RUN, provenance=versions())
    assert not can_resume(RUN, path)
    (path / "resources.json").unlink()
    assert can_resume(RUN, path)
    assert not can_resume(DEFAULT.run(1), path)
    assert not can_resume(RUN, tmp_path / "nowhere")
    other = finish(tmp_path, DEFAULT.run(1), provenance=versions() | {"torch": "1.0"})
    (other / "resources.json").unlink()
    assert not can_resume(DEFAULT.run(1), other)


def test_what_cannot_go_on_is_kept_aside_unless_a_process_writes_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each is hours of work: a run of other versions, one that is prolonged, a folder that is no run."""
    path = finish(tmp_path, RUN)
    with RunLock(path), pytest.raises(UserError, match="is being written by process"):
        archive_existing(path)
    archive_existing(path)
    assert f"it is kept as {path}.old1 and trained anew" in capsys.readouterr().out
    path.mkdir()
    (path / "precious.txt").write_text("mine")
    archive_existing(path)
    archive_existing(path)
    assert sorted(kept.name for kept in tmp_path.iterdir()) == [f"{RUN.name}.old1", f"{RUN.name}.old2"]
    assert (tmp_path / f"{RUN.name}.old2/precious.txt").read_text() == "mine"
