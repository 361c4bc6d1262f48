"""The groups behind the README's table."""

import json
from pathlib import Path

import pytest

from asddpg.build import make_environment
from asddpg.command_line import train_config
from asddpg.errors import UserError
from asddpg.runs.provenance import environment_hash
from tasks.evaluation_pairs import stored_pairs
from tests.support.fake_runs import finish_group
from tools import results
from tools.experiments import controller_alone
from tools.experiments.run_groups import missing


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_what_is_the_same_experiment_is_trained_once() -> None:
    names = [run.name for run in missing(results.GROUPS, [])]
    assert len(names) == 6 * 5 + 4 * 3
    assert not [name for name in names if name.startswith(("network_fc3x256", "gains_1_"))]


def test_the_table_of_the_runs_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    finish_group(results.FOLDER, "complex", results.GROUPS["complex"], [0.8, 0.9, 0.7, 0.6, 0.8])
    results.main(["table", "complex", "gains_1"])
    printed = capsys.readouterr().out
    assert "nav_complex, sparse, 100k steps, seed 4" in printed
    assert "nav_complex, P(1, 1), seed 2" in printed
    assert "missing" not in printed
    assert "The controller alone has not been driven here yet" in printed
    assert printed.startswith((results.FOLDER / "table.md").read_text().strip())


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [(["complx"], "there is no group 'complx'; there are empty, "), (["list", "table"], "not both")],
)
def test_wrong_words_are_one_sentence_and_create_nothing(arguments: list[str], sentence: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=sentence):
        results.main(arguments)
    assert not list(tmp_path.iterdir())


def test_the_controller_alone_is_measured_once_and_anew_where_the_task_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(controller_alone, "stored_pairs", lambda *arguments: stored_pairs(*arguments)[:3])
    config = train_config(["task=nav_empty", "task.min_linear_velocity=0", "controller.gains=[10,1]"])
    assert not controller_alone.measured([config], tmp_path, may_drive=False)
    found = controller_alone.measured([config, config], tmp_path, may_drive=True)
    path = tmp_path / "controller_nav_empty_P_10_1.json"
    kept = json.loads(path.read_text())
    assert found == {"nav_empty, P(10, 1)": kept}
    path.write_text(json.dumps(kept | {"spl": {"value": 0.5, "ci95": [0.4, 0.6]}}))
    again = controller_alone.measured([config], tmp_path, may_drive=True)
    assert "| 0.500 [0.400, 0.600] |" in controller_alone.table(again)
    config.task.min_linear_velocity = 0.05
    assert not controller_alone.measured([config], tmp_path, may_drive=False)
    assert not controller_alone.table({})


def test_configurations_that_differ_in_the_task_alone_do_not_take_each_others_figures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(controller_alone, "stored_pairs", lambda *arguments: stored_pairs(*arguments)[:2])
    arguments = ["task=nav_empty", "controller.gains=[10,1]"]
    configs = [train_config([*arguments, f"task.min_linear_velocity={v}"]) for v in (0, 0.05)]
    found = controller_alone.measured(configs, tmp_path, may_drive=True)
    assert list(found) == ["nav_empty, P(10, 1)", "nav_empty, P(10, 1), min_linear_velocity=0.05"]
    assert len(list(tmp_path.iterdir())) == 2
    assert controller_alone.measured(configs, tmp_path, may_drive=False) == found
    titles = {controller_alone.title_of(train_config([*arguments, f"task.laser.num_beams={n}"])) for n in (12, 24, 40)}
    assert len(titles) == 3


def test_the_controller_is_measured_anew_where_the_scene_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(controller_alone, "stored_pairs", lambda *arguments: stored_pairs(*arguments)[:1])
    config = train_config(["task=nav_empty"])
    found = controller_alone.measured([config], tmp_path, may_drive=True)
    environment = make_environment(config.task, config.reward)
    assert [content["model_hash"] for content in found.values()] == [environment_hash(environment)]
    monkeypatch.setattr(controller_alone, "scene_today", lambda *_: "another")
    assert not controller_alone.measured([config], tmp_path, may_drive=False)
