"""Damaged checkpoints and logs are recognised; the checkpoint before is used, and the run comes out the same."""

import json
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from asddpg import train
from asddpg.errors import UserError
from asddpg.runs import state_files
from asddpg.runs.lock import RunLock
from asddpg.runs.rewind import check_logs
from asddpg.runs.training_states import TrainingStates
from tests.support.small_runs import QUICK, Harmful, assert_same_run, at_step, stopped

FILES = (state_files.STATE, state_files.ARRAYS, state_files.SUMS)


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 1
    path.write_bytes(content)


def make_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


DAMAGES: dict[str, Callable[[Path], object]] = {
    "truncated": lambda path: path.write_bytes(path.read_bytes()[:-1]),
    "emptied": lambda path: path.write_bytes(b""),
    "one bit flipped": flip,
    "removed": Path.unlink,
    "a pickle": lambda path: path.write_bytes(pickle.dumps(Harmful())),
    "swapped for the one before": lambda path: shutil.copy(path.parent.parent / "step_00000100" / path.name, path),
    "a folder": make_folder,
}


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that was stopped at step 135, with checkpoints of that step and of step 100."""
    run = tmp_path_factory.mktemp("stopped") / "run"
    stopped([*QUICK, f"run_dir={run}"], 135)
    assert sorted(path.name for path in (run / "resume").iterdir()) == ["step_00000100", "step_00000135"]
    return run


@pytest.fixture
def run(template: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it to damage."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(template, tmp_path / "run")
    return Path("run")


def newest_step(run: Path) -> tuple[int, list[str]]:
    states = TrainingStates(run / "resume")
    state, damaged = states.newest(lambda each: check_logs(run, each["files"]))
    assert state is not None
    return state["step"], damaged


# Checkpoints ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("name", FILES)
def test_a_damaged_file_is_recognised_and_nothing_of_it_runs(run: Path, name: str, damage: str) -> None:
    assert newest_step(run) == (135, [])
    DAMAGES[damage](run / "resume/step_00000135" / name)
    step, (sentence,) = newest_step(run)
    assert step == 100
    assert "step_00000135 is damaged: " in sentence
    assert name in sentence
    assert "\n" not in sentence
    assert not Path("ran").exists()


@pytest.mark.parametrize("name", FILES)
def test_right_checksums_do_not_make_a_training_state(run: Path, name: str) -> None:
    folder = run / "resume/step_00000135"
    for content in (pickle.dumps(Harmful()), b"[]", b"{}", b"\x93NUMPY" + bytes(200), bytes(8) + b"{}"):
        (folder / name).write_bytes(content)
        if name != state_files.SUMS:
            (folder / state_files.SUMS).write_text(state_files._checksums(folder))
        assert newest_step(run)[0] == 100
    assert not Path("ran").exists()


def test_the_one_before_is_used_and_the_result_is_the_same(
    run: Path, unbroken: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flip(run / "resume/step_00000135/arrays.safetensors")
    train.main([f"resume={run}"])
    output = capsys.readouterr().out
    damage = "run/resume/step_00000135 is damaged: arrays.safetensors does not have the checksum"
    assert f"note: the training state {damage}" in output
    assert "resuming run at step 100 of 240" in output
    assert_same_run(unbroken, run)


def test_a_half_written_training_state_is_ignored(run: Path, unbroken: Path) -> None:
    """As a process leaves it that is killed while it writes."""
    shutil.copytree(run / "resume/step_00000135", run / "resume/step_00000150.part")
    (run / "resume/step_00000150.part/SHA256SUMS").unlink()
    shutil.copytree(run / "resume/step_00000135", run / "resume/step_00000137.part")
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)
    assert not list((run / "resume").glob("*.part"))


def test_both_damaged_is_one_sentence(run: Path) -> None:
    for path in (run / "resume").glob("*/arrays.safetensors"):
        flip(path)
    logged = (run / "metrics.csv").read_bytes()
    with pytest.raises(UserError, match=r"step_00000135 is damaged: .*step_00000100 is damaged: .*no other") as caught:
        train.main([f"resume={run}"])
    assert "\n" not in str(caught.value)
    assert (run / "metrics.csv").read_bytes() == logged


def test_a_training_state_of_another_step_is_damaged(run: Path) -> None:
    shutil.rmtree(run / "resume/step_00000135")
    shutil.copytree(run / "resume/step_00000100", run / "resume/step_00000135")
    assert newest_step(run)[0] == 100


# Logs -------------------------------------------------------------------------------------------------------------


LOOKED_AT = ("timing.csv", "tensorboard/events.out.tfevents.0000000000")
LOGS = ("metrics.csv", "validation.csv", "steps.f32", *LOOKED_AT)


@pytest.mark.parametrize("name", LOGS[:3])
def test_a_log_damaged_after_the_checkpoint_before(run: Path, unbroken: Path, name: str) -> None:
    """What was logged between the two is made again."""
    marks = state_files.read(run / "resume/step_00000100")["files"]
    with (run / name).open("r+b") as file:
        file.seek(marks[name]["bytes"] if name in marks else 0)
        if not file.read(1):
            pytest.skip("nothing was logged between the two")
        file.seek(-1, 1)
        file.write(b"#")
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


@pytest.mark.parametrize("damage", ["emptied", "one bit flipped", "removed"])
@pytest.mark.parametrize("name", ["metrics.csv", "steps.f32"])
def test_a_log_damaged_before_both_is_a_sentence(run: Path, name: str, damage: str) -> None:
    DAMAGES[damage](run / name)
    with pytest.raises(UserError, match=f"{name}, which belongs to it, .*no other one"):
        train.main([f"resume={run}"])


@pytest.mark.parametrize("damage", ["emptied", "one bit flipped", "removed"])
@pytest.mark.parametrize("name", LOOKED_AT)
def test_logs_that_nothing_reads_back_may_be_gone(run: Path, unbroken: Path, name: str, damage: str) -> None:
    DAMAGES[damage](run / name)
    train.main([f"resume={run}"])
    assert (run / "metrics.csv").read_bytes() == (unbroken / "metrics.csv").read_bytes()
    assert json.loads((run / "test.json").read_text()) == json.loads((unbroken / "test.json").read_text())


def test_what_was_logged_later_is_no_damage(run: Path, unbroken: Path) -> None:
    """As a killed process leaves it, in the middle of a row."""
    for name in LOGS:
        with (run / name).open("ab") as file:
            file.write(b"138,7,cra")
    (run / "episodes/00000136_00009.mcap.part").write_bytes(b"half")
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


# The lock ---------------------------------------------------------------------------------------------------------


def test_a_run_that_is_being_written_is_refused(run: Path) -> None:
    with RunLock(run), pytest.raises(UserError, match=r"being written by process \d+ on .*; one process at a time"):
        train.main([f"resume={run}"])


def test_the_lock_of_a_dead_process_is_free(run: Path) -> None:
    (run / "lock").write_text("process 1 on elsewhere\n")
    with RunLock(run):
        assert (run / "lock").read_text().startswith("process ")
        assert "elsewhere" not in (run / "lock").read_text()


@pytest.mark.parametrize("is_replaced", [False, True])
def test_without_its_lock_a_run_stops(run: Path, is_replaced: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    def take_away() -> None:
        (run / "lock").unlink()
        if is_replaced:
            (run / "lock").touch()

    at_step(monkeypatch, 140, take_away)
    with pytest.raises(UserError, match="lock has been removed or replaced"):
        train.main([f"resume={run}"])
    assert newest_step(run)[0] == 135
