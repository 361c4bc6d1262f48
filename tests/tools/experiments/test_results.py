"""The groups behind the published results, and the controller alone beside them."""

from pathlib import Path

import pytest

from asddpg.command_line import train_config
from asddpg.errors import UserError
from tasks.evaluation_pairs import stored_pairs
from tests.support.fake_runs import finish_group
from tools import results
from tools.experiments import controller_alone
from tools.experiments.run_store import RunStore


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_what_is_the_same_experiment_is_trained_once(tmp_path: Path) -> None:
    titles = [run.title for run in RunStore(tmp_path).missing(results.GROUPS)]
    assert len(titles) == 4 * 5 + 6 * 5 + 4 * 3
    assert not [title for title in titles if "fc3x256" in title or "P(1, 1)" in title]


def test_the_table_of_the_finished_runs(capsys: pytest.CaptureFixture[str]) -> None:
    finish_group(results.FOLDER, results.GROUPS["complex_one_robot"], [0.8, 0.9, 0.7, 0.6, 0.8])
    results.main(["table", "complex_one_robot", "gains_1_one_robot"])
    printed = capsys.readouterr().out
    assert "nav_complex, sparse, 100k steps, one robot, seed 4" in printed
    assert "nav_complex, P(1, 1), one robot, seed 2" in printed
    assert "missing" not in printed
    assert "The controller alone has not been driven here yet" in printed
    assert printed.startswith((results.FOLDER / "table.md").read_text().strip())


def test_a_group_that_is_unknown_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="there is no group 'complx'; there are empty, "):
        results.main(["complx"])
    assert not list(tmp_path.iterdir())


def test_the_controller_alone_is_measured_once_for_each_setting_of_the_task(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(controller_alone, "stored_pairs", lambda *arguments: stored_pairs(*arguments)[:2])
    arguments = ["task=nav_empty", "controller.gains=[10,1]"]
    configs = [train_config([*arguments, f"task.min_linear_velocity={v}"]) for v in (0, 0.05, 0)]
    assert not controller_alone.table(configs, tmp_path, may_drive=False)
    table = controller_alone.table(configs, tmp_path, may_drive=True)
    titles = ["nav_empty, P(10, 1)", "nav_empty, P(10, 1), min_linear_velocity=0.05"]
    assert [line.split(" | ")[0] for line in table.splitlines()[2:4]] == [f"| {title}" for title in titles]
    assert capsys.readouterr().out.splitlines() == [f"measured the controller alone: {title}" for title in titles]
    assert controller_alone.table(configs, tmp_path, may_drive=False) == table
    monkeypatch.setattr(controller_alone, "current_scene", lambda *_: "another")
    assert not controller_alone.table(configs, tmp_path, may_drive=False)
