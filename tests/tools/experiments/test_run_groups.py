"""Which runs there are, which would be trained, and which are no longer what is asked for."""

from pathlib import Path

import pytest
import yaml

from asddpg.errors import UserError
from asddpg.runs.lock import RunLock
from asddpg.runs.provenance import versions
from tests.support.fake_runs import finish, finish_group
from tools.experiments.run_groups import Group, finished, missing
from tools.experiments.run_store import archive_existing, differences, is_begun, stored_runs

DEFAULT = Group("default", ("task=nav_empty",), 1000, (0, 1, 2))
WIDTHS = Group("fc3x256", ("task=nav_empty", "network=fc3x256"), 1000, (0, 1))
SMALL = Group("fc2x100", ("task=nav_empty", "network=fc2x100"), 1000, (0,))
GROUPS = {"default": DEFAULT, "widths": WIDTHS, "small": SMALL}


def test_an_experiment_that_two_groups_ask_for_is_trained_once() -> None:
    runs = missing(GROUPS, [])
    assert [run.name for run in runs] == ["default_seed0", "default_seed1", "default_seed2", "small_seed0"]
    assert runs[0].arguments == ("total_steps=1000", "validation.every=50", "task=nav_empty", "seed=0")


def test_a_finished_run_serves_every_group_that_asks_for_it(tmp_path: Path) -> None:
    finish_group(tmp_path, "widths", WIDTHS, [0.5, 0.6])
    stored = stored_runs(tmp_path)
    assert [run.name for run in missing(GROUPS, stored)] == ["default_seed2", "small_seed0"]
    found = finished(GROUPS, stored)
    assert [run.settings["seed"] for run in found["default"]] == [0, 1]
    assert found["default"] == found["widths"]
    assert not found["small"]


@pytest.mark.parametrize("lacking", ["resources.json", "config.yaml"])
def test_a_run_that_was_broken_off_is_not_finished(lacking: str, tmp_path: Path) -> None:
    (finish(tmp_path / "default_seed0", DEFAULT.settings(0)) / lacking).unlink()
    assert not stored_runs(tmp_path)


@pytest.mark.parametrize("text", ["", "- 1", "{", "task: {name: nav_empty}"])
def test_a_run_whose_configuration_is_damaged_serves_nobody(text: str, tmp_path: Path) -> None:
    (finish(tmp_path / "default_seed0", DEFAULT.settings(0)) / "config.yaml").write_text(text)
    assert not stored_runs(tmp_path)


def test_a_run_with_an_option_less_than_there_is_today_is_another_experiment(tmp_path: Path) -> None:
    """What an option was before there was one is not known."""
    settings = DEFAULT.settings(0)
    del settings["agent"]["n_steps"]
    finish(tmp_path / "default_seed0", settings)
    assert "default_seed0" in [run.name for run in missing(GROUPS, stored_runs(tmp_path))]


def test_a_run_with_other_options_is_kept_aside_and_named(tmp_path: Path) -> None:
    old = Group("old", ("task=nav_empty", "agent.imitation=0.5"), 1000, (0,))
    path = finish(tmp_path / "default_seed0", old.settings(0))
    said = archive_existing(path, DEFAULT.settings(0))
    assert not path.exists()
    assert "agent.imitation was 0.5 and is 1.0" in said
    assert f"kept as {path}.old1" in said
    # And it is found again by whoever asks for it.
    assert not missing({"old": old}, stored_runs(tmp_path))
    finish(path, old.settings(0))
    archive_existing(path, DEFAULT.settings(0))
    assert (tmp_path / "default_seed0.old2").is_dir()


def test_what_cannot_go_on_is_kept_aside(tmp_path: Path) -> None:
    """A run of other versions, one that somebody prolongs, a folder that is no run: hours of work, each of them."""
    path = finish(tmp_path / "default_seed0", DEFAULT.settings(0))
    (path / "resources.json").unlink()
    assert "other versions" in archive_existing(path, DEFAULT.settings(0))
    path.mkdir()
    (path / "precious.txt").write_text("mine")
    assert "kept as" in archive_existing(path, DEFAULT.settings(0))
    assert (tmp_path / "default_seed0.old2/precious.txt").read_text() == "mine"


def test_a_run_that_is_being_written_stays_where_it_is(tmp_path: Path) -> None:
    path = finish(tmp_path / "default_seed0", DEFAULT.settings(0))
    (path / "resources.json").unlink()
    with RunLock(path), pytest.raises(UserError, match="is being written by process"):
        archive_existing(path, DEFAULT.settings(1))
    assert (path / "config.yaml").is_file()


def test_a_prolonged_run_is_not_the_experiment_of_its_options(tmp_path: Path) -> None:
    path = finish(tmp_path / "default_seed0", DEFAULT.settings(0))
    config = path / "config.yaml"
    content = yaml.safe_load(config.read_text())
    content["provenance"]["prolonged"] = "from 500 to 1000 at step 500"
    config.write_text(yaml.safe_dump(content))
    assert not stored_runs(tmp_path)
    assert "prolonged" in archive_existing(path, DEFAULT.settings(0))


def test_only_an_unfinished_run_of_the_same_options_goes_on(tmp_path: Path) -> None:
    path = finish(tmp_path / "default_seed0", DEFAULT.settings(0))
    assert not is_begun(path, DEFAULT.settings(0))
    (path / "resources.json").unlink()
    assert not is_begun(path, DEFAULT.settings(0))  # of another version
    config = path / "config.yaml"
    content = yaml.safe_load(config.read_text()) | {"provenance": versions()}
    config.write_text(yaml.safe_dump(content))
    assert is_begun(path, DEFAULT.settings(0))
    config.write_text(yaml.safe_dump(content | {"provenance": versions() | {"resumed": "at step 5 with torch 1"}}))
    assert not is_begun(path, DEFAULT.settings(0))
    config.write_text(yaml.safe_dump(content))
    assert not is_begun(path, DEFAULT.settings(1))
    assert not is_begun(tmp_path / "nowhere", DEFAULT.settings(0))


def test_differences_are_named_on_both_sides() -> None:
    old, new = {"a": {"b": 1, "c": None}, "d": 2}, {"a": {"b": 3, "c": None}, "e": None}
    assert differences(old, new) == ["a.b was 1 and is 3", "e was not there and is None", "d was 2 and is not there"]


def test_a_wrong_word_is_one_sentence() -> None:
    with pytest.raises(UserError, match="did you mean"):
        missing({"wrong": Group("wrong", ("agent.imitaton=1",), 1000, (0,))}, [])
