"""Ctrl-C and SIGTERM finish the step, save everything and print how to resume."""

import math
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from asddpg import train
from asddpg.program import python
from asddpg.recording.live.listener import LiveListener
from asddpg.recording.live.live_view import LiveView
from asddpg.runs.training_states import TrainingStates
from tests.support.small_runs import QUICK, assert_same_run, at_step, interrupt, newest_state, stopped

PATIENCE = 300.0  # s


def wait_for_rows(run: Path, process: subprocess.Popen[str]) -> None:
    """Until an episode is over."""
    end = time.monotonic() + PATIENCE
    metrics = run / "metrics.csv"
    while not metrics.is_file() or metrics.read_bytes().count(b"\n") < 2:
        assert process.poll() is None, "it has ended before it was to be stopped"
        assert time.monotonic() < end
        time.sleep(0.005)


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_keeps_everything(number: signal.Signals, status: int, unbroken: Path, run: Path) -> None:
    arguments = [sys.executable, "-m", "asddpg.train", *QUICK, f"run_dir={run}"]
    process = subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_for_rows(run, process)
    process.send_signal(number)
    output = process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == status
    assert "Traceback" not in output
    assert not list(run.rglob("*.part"))
    step = newest_state(run)["step"]
    assert 0 < step < 240
    assert output.splitlines()[-1] == f"stopped after step {step}; to resume: {python()} -m asddpg.train resume={run}"
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


def test_a_second_signal_stops_at_once(
    unbroken: Path, run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def twice() -> None:
        interrupt()
        interrupt()

    with monkeypatch.context() as patch:
        at_step(patch, 125, twice)
        with pytest.raises(KeyboardInterrupt):
            train.main([*QUICK, f"run_dir={run}"])
    assert newest_state(run)["step"] == 100
    assert (
        f"can resume from its last training state: {python()} -m asddpg.train resume={run}" in capsys.readouterr().err
    )
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


def test_a_second_signal_while_a_checkpoint_is_written(
    unbroken: Path, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = TrainingStates.write

    def write(self: TrainingStates, step: int, state: dict[str, object]) -> None:
        if step == 125:
            monkeypatch.setattr("asddpg.runs.state_files.to_disk", lambda _: interrupt())
        real(self, step, state)

    at_step(monkeypatch, 125, interrupt)
    monkeypatch.setattr(TrainingStates, "write", write)
    with pytest.raises(KeyboardInterrupt):
        train.main([*QUICK, f"run_dir={run}"])
    monkeypatch.undo()
    assert sorted(path.name for path in (run / "resume").iterdir()) == ["step_00000050", "step_00000100"]
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_the_same_signal_twice_keeps_everything(number: signal.Signals, run: Path) -> None:
    """As a child of make is, or of a session that is ended."""

    def twice() -> None:
        os.kill(os.getpid(), number)
        os.kill(os.getpid(), signal.SIGTERM)

    assert stopped([*QUICK, f"run_dir={run}"], 125, twice) == 128 + number
    assert newest_state(run)["step"] == 125


def test_a_signal_ends_a_paused_live_view(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    timers: list[threading.Timer] = []

    def paused(_: LiveView, __: float) -> float:
        if not timers:
            timers.append(threading.Timer(0.5, interrupt))
            timers[0].start()
        return math.inf

    monkeypatch.setattr(LiveListener, "has_viewers", True)
    monkeypatch.setattr(LiveView, "_remaining", paused)
    with pytest.raises(SystemExit) as ended:
        train.main([*QUICK, "live=true", "port=0", f"run_dir={tmp_path / 'run'}"])
    assert ended.value.code == 130
