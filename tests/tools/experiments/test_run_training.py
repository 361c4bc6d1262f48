"""Training runs in processes of their own: two at a time, failures, interrupts."""

import signal
import sys
from pathlib import Path

import pytest

from asddpg.errors import UserError
from tests.support.fake_runs import finish
from tools.experiments import run_training
from tools.experiments.run_store import RunStore
from tools.experiments.runs import Group, Run

GROUP = Group("empty", ("task=nav_empty",), 1000, (0, 1, 2, 3))
RUNS = [GROUP.run(seed) for seed in GROUP.seeds]


def pretend(monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    """Training is a script with the run's folder as its argument, and whether it resumes."""
    monkeypatch.setattr(run_training, "LOOK_EVERY", 0.01)
    script = f"import os, pathlib, signal, sys, time; path = pathlib.Path(sys.argv[1])\n{script}"
    arguments = [sys.executable, "-S", "-c", script]
    monkeypatch.setattr(run_training, "train_command", lambda _, path, resumes: [*arguments, str(path), str(resumes)])


def test_two_run_at_a_time_and_one_that_fails_does_not_stop_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    script = "print('here', flush=True); path.mkdir(); busy = path.with_suffix('.busy'); busy.touch()\n"
    script += "time.sleep(0.3); count = len(list(path.parent.glob('*.busy'))); busy.unlink()\n"
    pretend(monkeypatch, script + "sys.exit(3 * ('seed1' in path.name or count > 2))")
    assert run_training.train(RUNS, tmp_path / "runs") == [RUNS[1]]
    assert len(list((tmp_path / "runs").glob("*/"))) == 4
    assert run_training.log_path(RUNS[1], tmp_path / "runs").read_text() == "here\n"
    printed = capsys.readouterr().out
    assert "empty, seed 1 FAILED with status 3" in printed
    assert "(4 of 4)" in printed
    assert run_training.describe_exit(-9) == "FAILED, stopped by SIGKILL"


def test_an_interrupted_run_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    command = run_training.train_command(RUNS[0], Path("here"), resumes=False)
    assert command[1:] == ["-m", "asddpg.train", *GROUP.options, "seed=0", "run_dir=here"]
    own = Run("", ("controller.type=mine:Own", "seed=1"), RUNS[0].config)
    command = run_training.train_command(own, Path("here"), resumes=True)
    assert command[3:] == ["resume=here", "controller.type=mine:Own"]
    pretend(monkeypatch, "print('resumes' if sys.argv[2] == 'True' else 'begins')")
    monkeypatch.setattr(run_training, "can_resume", lambda run, _: run is RUNS[0])
    logs = [run_training.log_path(run, tmp_path) for run in RUNS[:2]]
    logs[0].write_text("begun\n")
    assert not run_training.train(RUNS[:2], tmp_path)
    assert [log.read_text() for log in logs] == ["begun\nresumes\n", "begins\n"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupt_stops_what_runs_and_keeps_what_is_finished(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The training of seed 1 sends it once that of seed 2 runs too; both note that they were stopped."""
    finish(tmp_path, RUNS[0])
    pretend(
        monkeypatch,
        f"""
signal.signal(signal.SIGTERM, signal.default_int_handler)
try:
    path.mkdir()
    while len(list(path.parent.glob('*_seed*/'))) < 3:
        time.sleep(0.01)
    if 'seed1' in path.name:
        os.kill(os.getppid(), {int(number)})
    time.sleep(600)
except KeyboardInterrupt:
    (path / "stopped").touch()
""",
    )
    with pytest.raises(KeyboardInterrupt):
        run_training.train(RUNS[1:], tmp_path)
    assert all((tmp_path / run.name / "stopped").exists() for run in RUNS[1:3])
    assert not (tmp_path / RUNS[3].name).exists()
    assert RunStore(tmp_path).find(RUNS[0])


def test_trainings_that_outlive_a_killed_program_keep_their_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As two programs never train into one folder."""
    pretend(monkeypatch, "time.sleep(600)")
    with run_training.lock_folder(tmp_path) as lock:
        process = run_training.start(RUNS[0], tmp_path, lock)
    with pytest.raises(UserError, match="another program is training into"):
        run_training.train(RUNS, tmp_path)
    process.kill()
    process.wait()
    pretend(monkeypatch, "")
    assert not run_training.train(RUNS, tmp_path)
