"""The command as a user types it."""

import json
import shutil
import sys
from pathlib import Path

import pytest
from PIL import Image

from asddpg import train
from asddpg.build import make_agent, make_environment
from asddpg.errors import UserError
from asddpg.observers.metrics_log import read_rows
from asddpg.runs.run_folder import RunFolder, read_training
from tests.conftest import TINY
from tools import diagnose
from tools.diagnose import list_weights

PLOTS = {"outcomes.png", "controller_share.png", "q_values.png", "actions.png", "ends.png", "td_errors.png"}


@pytest.fixture
def run(tiny_run: Path, tmp_path: Path) -> Path:
    """A copy that may be written to."""
    return Path(shutil.copytree(tiny_run, tmp_path / "run"))


def test_a_run_is_diagnosed(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    diagnose.main([f"run={run}", "episodes=2"])
    assert {path.name for path in (run / "diagnosis").iterdir()} == {*PLOTS, "diagnosis.json", "lock"}
    for name in PLOTS:
        with Image.open(run / "diagnosis" / name) as picture:
            assert min(picture.size) > 300
    found = json.loads((run / "diagnosis/diagnosis.json").read_text())
    assert [snapshot["step"] for snapshot in found["snapshots"]][-1] == 400
    assert len(found["snapshots"]) == 2
    for metrics in (found["controller"], *(s[name] for s in found["snapshots"] for name in ("actor", "switched"))):
        assert sum(metrics[f"{name}_rate"]["value"] for name in ("success", "collision", "timeout")) == pytest.approx(
            1.0
        )
        assert len(metrics["ends"]) == metrics["episodes"] == 2
    validated = read_rows(run / "validation.csv")
    for row, snapshot in zip(validated, found["snapshots"], strict=True):
        first = snapshot["actor"]["ends"][0]["outcome"]  # training validated on this pair alone
        assert (int(row["step"]), float(row["success_rate"])) == (snapshot["step"], first == "reached")
        assert float(row["collision_rate"]) == (first == "crashed")
    assert found["controller"]["controller_share"] == 1.0
    assert {snapshot["actor"]["controller_share"] for snapshot in found["snapshots"]} == {0.0}
    assert "step 400: success rate actor alone" in capsys.readouterr().out


def test_the_end_of_a_training_that_went_on_after_its_last_snapshot(run: Path) -> None:
    folder = RunFolder(run)
    config, _ = read_training(folder.config)
    agent = make_agent(config, make_environment(config.task, config.reward))
    first, second = folder.snapshots()
    last = folder.checkpoint("last")
    assert list_weights(folder, agent, 1) == [first, second]  # the last snapshot is of the training's end
    second.unlink()
    assert list_weights(folder, agent, 1) == [first, last]
    assert list_weights(folder, agent, 2) == [last]
    diagnose.main([f"run={run}", "episodes=1", "every=2"])
    found = json.loads((run / "diagnosis/diagnosis.json").read_text())
    assert [snapshot["step"] for snapshot in found["snapshots"]] == [400]
    last.unlink()
    assert list_weights(folder, agent, 1) == [first]


def test_a_damaged_step_log_is_named_before_the_driving(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnose, "Examiner", None)  # driving would fail
    (run / "steps.npz").write_bytes(b"half a log")
    with pytest.raises(UserError, match=r"steps\.npz is damaged"):
        diagnose.main([f"run={run}"])


def test_ddpg_has_neither_switched_policy_nor_controller(tmp_path: Path) -> None:
    run = tmp_path / "run"
    train.main(["task=nav_empty", "agent=ddpg", *TINY, "total_steps=200", f"run_dir={run}"])
    diagnose.main([f"run={run}", "episodes=1"])
    assert {path.name for path in (run / "diagnosis").glob("*.png")} == PLOTS - {"controller_share.png"}
    found = json.loads((run / "diagnosis/diagnosis.json").read_text())
    assert found["controller"] is None
    (snapshot,) = found["snapshots"]
    assert snapshot["q_actor"] is not None
    assert {snapshot[name] for name in ("switched", "q_policy", "q_switched", "q_controller")} == {None}


def test_a_run_in_progress_or_without_snapshots_is_diagnosed_from_what_it_has(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for path in (*run.glob("checkpoints/step_*"), run / "steps.npz"):
        path.unlink()
    (run / "metrics.csv").write_bytes((run / "metrics.csv").read_bytes()[:-30])
    diagnose.main([f"run={run}", "episodes=1"])
    assert {path.name for path in (run / "diagnosis").glob("*.png")} == PLOTS
    printed = capsys.readouterr().out
    assert "kept no snapshots" in printed
    assert "steps.npz" in printed
    found = json.loads((run / "diagnosis/diagnosis.json").read_text())
    training = found["training"]
    assert (len(found["snapshots"]), training["by_distance"], training["by_place"]) == (1, [], [])
    assert training["windows"]["driven"]


def test_a_run_with_damaged_weights_or_without_any(run: Path) -> None:
    path = RunFolder(run).snapshots()[0]
    path.write_bytes(b"half a snapshot")
    with pytest.raises(UserError, match=f"{path.name} is damaged or not a file of weights"):
        diagnose.main([f"run={run}", "episodes=1"])
    shutil.rmtree(run / "checkpoints")
    with pytest.raises(UserError, match="neither snapshots nor a last checkpoint"):
        diagnose.main([f"run={run}"])


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["run=x", "episodes=51"], "episodes must be from 1 to 50, not 51"),
        (["run=pretrained:nav_complex"], "needs the folder of a training run, .* pretrained:nav_complex has none"),
        (["run=nowhere"], "nowhere is not the folder of a run"),
    ],
)
def test_invalid_arguments_are_one_sentence(arguments: list[str], sentence: str) -> None:
    with pytest.raises(UserError, match=sentence):
        diagnose.main(arguments)


def test_without_matplotlib_one_sentence_says_what_to_install(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)  # as if it were not installed
    with pytest.raises(UserError, match=r"plots need matplotlib, .* pip install .asddpg.plots"):
        diagnose.main([f"run={run}"])
