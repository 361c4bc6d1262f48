"""Training runs in processes of their own: two at a time, failures, interrupts."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from asddpg.errors import UserError
from tests.support.fake_runs import finish
from tools.experiments import run_training
from tools.experiments.run_groups import Group, Run, missing

GROUP = Group("empty", ("task=nav_empty",), 1000, (0, 1, 2, 3))


def pretend(monkeypatch: pytest.MonkeyPatch, script: str) -> list[Run]:
    """Runs whose training is a script with the run's folder as its argument."""
    monkeypatch.setattr(run_training, "LOOK_EVERY", 0.01)
    monkeypatch.setattr(run_training, "command", lambda _, path, __: [sys.executable, "-S", "-c", script, str(path)])
    return missing({"empty": GROUP}, [])


def test_a_run_that_fails_does_not_stop_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    script = (
        "import os, sys; print('here', flush=True); os.makedirs(sys.argv[1]); sys.exit(3 * ('seed1' in sys.argv[1]))"
    )
    runs = pretend(monkeypatch, script)
    failed = run_training.train(runs, tmp_path / "runs")
    assert [run.name for run in failed] == ["empty_seed1"]
    assert len(list((tmp_path / "runs").glob("*/"))) == 4
    assert run_training.log_of(failed[0], tmp_path / "runs").read_text() == "here\n"
    printed = capsys.readouterr().out
    assert "empty_seed1 FAILED with status 3" in printed
    assert "(4 of 4)" in printed


def test_two_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = (
        "import os, pathlib, sys, time; path = pathlib.Path(sys.argv[1]); path.mkdir(); time.sleep(0.3)\n"
        "there = sorted(p.name for p in path.parent.glob('*.busy')); mine = path.with_suffix('.busy'); mine.touch()\n"
        "time.sleep(0.3); mine.unlink(); sys.exit(len(there) > 1)"
    )
    assert not run_training.train(pretend(monkeypatch, script), tmp_path)


def test_the_command_trains() -> None:
    (run, *_) = missing({"empty": GROUP}, [])
    arguments = run_training.command(run, Path("here"), goes_on=False)
    assert arguments[1:3] == ["-m", "asddpg.train"]
    assert arguments[3:] == [*GROUP.options, "seed=0", "run_dir=here"]
    assert run_training.command(run, Path("here"), goes_on=True)[3:] == ["resume=here"]


def test_a_run_that_was_broken_off_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a script that says how it was called, after what the first attempt said."""
    runs = pretend(monkeypatch, "")[:2]
    monkeypatch.setattr(run_training, "is_begun", lambda path, _: path.name == runs[0].name)
    run_training.log_of(runs[0], tmp_path).write_text("begun\n")
    arguments: dict[str, bool] = {}

    def command(run: Run, _: Path, goes_on: bool) -> list[str]:
        arguments[run.name] = goes_on
        return [sys.executable, "-S", "-c", f"print('goes on' if {goes_on} else 'begins')"]

    monkeypatch.setattr(run_training, "command", command)
    assert not run_training.train(runs, tmp_path)
    assert arguments == {runs[0].name: True, runs[1].name: False}
    assert run_training.log_of(runs[0], tmp_path).read_text() == "begun\ngoes on\n"
    assert run_training.log_of(runs[1], tmp_path).read_text() == "begins\n"


def test_a_signal_is_named() -> None:
    assert run_training.how_it_ended(-9) == "FAILED, stopped by SIGKILL"


def test_two_programs_do_not_train_into_one_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = pretend(monkeypatch, "")
    with run_training._alone_in(tmp_path), pytest.raises(UserError, match="another program"):
        run_training.train(runs, tmp_path)


INTERRUPTED = """
import sys, pathlib, signal
from tools import run_training
from tools.experiments.run_groups import Group, missing
script = "import os, sys, time, pathlib; p = pathlib.Path(sys.argv[1]); p.mkdir(); (p / str(os.getpid())).touch();"
script += "time.sleep(60 * ('seed0' not in sys.argv[1]))"
run_training.command = lambda run, path, _: [sys.executable, "-S", "-c", script, str(path)]
group = Group("", ("task=nav_empty",), 1000, (0, 1, 2, 3))
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may start tests with it ignored
try:
    run_training.train(missing({"empty": group}, []), pathlib.Path(sys.argv[1]))
except KeyboardInterrupt:
    sys.exit(130)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_stops_what_runs_and_keeps_what_is_finished(number: signal.Signals, tmp_path: Path) -> None:
    finish(tmp_path / "kept_seed0", GROUP.settings(0))
    process = subprocess.Popen([sys.executable, "-c", INTERRUPTED, str(tmp_path)], stdout=subprocess.DEVNULL)
    processes = [int(wait_for(tmp_path, f"empty_seed{seed}/*").name) for seed in (1, 2)]
    process.send_signal(number)
    assert process.wait(20) == 130
    for identity in processes:
        with pytest.raises(ProcessLookupError):
            os.kill(identity, 0)
    assert not (tmp_path / "empty_seed3").exists()
    assert (tmp_path / "kept_seed0/resources.json").exists()


def test_trainings_that_outlive_a_killed_program_keep_their_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    runs = pretend(monkeypatch, "")
    process = subprocess.Popen([sys.executable, "-c", INTERRUPTED, str(tmp_path)], stdout=subprocess.DEVNULL)
    processes = [int(wait_for(tmp_path, f"empty_seed{seed}/*").name) for seed in (1, 2)]
    process.kill()
    process.wait()
    for identity in processes:
        with pytest.raises(UserError, match="another program"):
            run_training.train(runs, tmp_path)
        os.kill(identity, signal.SIGKILL)
        # No child of this process, so there is nothing to wait on but the lock.
        time.sleep(0.5)
    assert not run_training.train(runs, tmp_path)


def wait_for(folder: Path, pattern: str) -> Path:
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        if found := list(folder.glob(pattern)):
            return found[0]
        time.sleep(0.05)
    raise AssertionError(f"no {pattern} came")
