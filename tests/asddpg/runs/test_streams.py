"""Standard streams that cannot encode, are closed, full or gone, and callers of main() with streams of their own."""

import io
import shlex
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import torch

from asddpg import evaluate, play, train
from asddpg.build import prepare_torch
from asddpg.program import python
from tests.support.small_runs import QUICK, assert_same_run, newest_state

CLOSED = io.StringIO()
CLOSED.close()


def shell(form: str, *words: str) -> tuple[int, str]:
    """Exit status and standard error of a program in a line of a shell."""
    line = form.format(shlex.join([sys.executable, "-m", *words]))
    done = subprocess.run(["bash", "-o", "pipefail", "-c", line], capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    return done.returncode, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("form", "status"), [("PYTHONIOENCODING=ascii {} 2> /dev/full", 0), ("{} >&- 2>&- <&-", 0), ("{} > /dev/full", 2)]
)
def test_nothing_is_lost_to_a_message(form: str, status: int, unbroken: Path, tmp_path: Path) -> None:
    run = tmp_path / "läufe"
    assert shell(form, "asddpg.train", *QUICK, f"run_dir={run}")[0] == status
    assert_same_run(unbroken, run)
    assert shell(form, "asddpg.evaluate", f"run={run}", "episodes=1", "record.every=1")[0] == status
    assert shell(form, "asddpg.play", f"run={run}", "episodes=2")[0] == status
    assert shell(form, "tools.episodes", str(run), f"export={run}/steps.csv")[0] == status
    assert (run / "evaluation.json").exists()
    assert (run / "steps.csv").exists()
    assert [len(list((run / f"{name}_episodes").glob("*.mcap"))) for name in ("evaluated", "played")] == [1, 2]


@pytest.mark.slow
@pytest.mark.parametrize("form", ["{} | true", "{} 2>&1 | true"])
def test_a_broken_pipe_counts_as_a_closed_terminal(form: str, unbroken: Path, run: Path) -> None:
    status, said = shell(form, "asddpg.train", *QUICK, f"run_dir={run}")
    assert status == 128 + signal.SIGHUP
    again = f"stopped after step {newest_state(run)['step']}; to resume: {python()} -m asddpg.train resume={run}"
    assert said.splitlines()[-1:] == ([] if "2>" in form else [again])
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)
    assert shell(form, "asddpg.evaluate", f"run={run}", "episodes=1")[0] == 0
    assert (run / "evaluation.json").exists()
    shell(form, "tools.episodes", str(run), f"export={run}/steps.csv")
    assert (run / "steps.csv").exists()


@pytest.mark.parametrize("stream", [None, CLOSED, object()], ids=["none", "closed", "no stream"])
def test_any_stream_of_a_caller_will_do(
    stream: object, unbroken: Path, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdout", stream)
    monkeypatch.setattr(sys, "stderr", stream)
    train.main([*QUICK, f"run_dir={run}"])
    assert_same_run(unbroken, run)
    evaluate.main([f"run={run}", "episodes=1"])
    play.main([f"run={run}", "episodes=1"])


def test_threads_train_at_once(unbroken: Path, tmp_path: Path) -> None:
    with ThreadPoolExecutor() as pool:
        list(pool.map(lambda name: train.main([*QUICK, f"run_dir={tmp_path / name}"]), "ab"))
    assert_same_run(unbroken, tmp_path / "a")
    assert_same_run(unbroken, tmp_path / "b")


def settings() -> list[object]:
    """What a training changes while it lasts."""
    handlers = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    has_denormals = sys.float_info.min / 2 > 0
    draws = torch.get_rng_state().tolist()
    return [*handlers, torch.get_num_threads(), torch.get_default_dtype(), has_denormals, draws]


def test_settings_return_with_the_last_of_two_threads_that_end_in_any_order() -> None:
    first, second, before = prepare_torch(), prepare_torch(), torch.get_default_dtype()
    torch.set_default_dtype(torch.float64)
    try:
        first.__enter__()
        second.__enter__()
        first.__exit__(None, None, None)
        assert torch.get_default_dtype() == torch.float32
        second.__exit__(None, None, None)
        assert torch.get_default_dtype() == torch.float64
    finally:
        torch.set_default_dtype(before)


def test_a_caller_finds_its_settings_as_they_were(unbroken: Path, run: Path) -> None:
    torch.set_num_threads(3)
    torch.set_default_dtype(torch.float64)
    torch.set_flush_denormal(False)
    before = settings()
    try:
        with torch.inference_mode():
            train.main([*QUICK, f"run_dir={run}"])
        assert settings() == before
    finally:
        torch.set_num_threads(1)
        torch.set_default_dtype(torch.float32)
        torch.set_flush_denormal(True)
    assert_same_run(unbroken, run)
