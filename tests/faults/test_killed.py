"""20 runs of 5,000 steps, killed three times each and resumed: 25 minutes on two idle cores, 1 with ASDDPG_FAULTS=0.05.

Bars: 20 of 20 equal the unbroken run to the last bit; a kill costs at most one checkpoint interval.
"""

import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from asddpg.observers.metrics_log import read_rows
from tests.faults.scale import scaled
from tests.support.small_runs import assert_same_run

pytestmark = pytest.mark.faults

RUNS, STEPS, EVERY, KILLS = scaled(20), 5000, 400, 3
WORDS = ["task=nav_empty", "network=fc2x100", f"total_steps={STEPS}", f"checkpoint_every={EVERY}", "record.every=10"]
WORDS += ["validation.every=1000", "validation.episodes=3", "test_episodes=5"]
PATIENCE = 1800.0  # s; others may have the processors


def train(*arguments: str) -> subprocess.Popen[bytes]:
    program = [sys.executable, "-m", "asddpg.train", *arguments]
    return subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def finish(process: subprocess.Popen[bytes]) -> None:
    assert process.wait(PATIENCE) == 0


def logged_step(run: Path) -> int:
    rows = read_rows(run / "metrics.csv")
    return int(rows[-1]["step"] or 0) if rows else 0


def kept_step(run: Path) -> int:
    return max((int(path.name[5:]) for path in (run / "resume").glob("step_????????")), default=0)


def kill(process: subprocess.Popen[bytes], run: Path, step: int, while_writing: bool, delay: float) -> bool:
    """Kill it once an episode after `step` is over, or once it writes a checkpoint then; whether it wrote one."""
    end = time.monotonic() + PATIENCE
    while process.poll() is None and time.monotonic() < end:
        if logged_step(run) >= step and (not while_writing or any((run / "resume").glob("*.part"))):
            break
        time.sleep(0.002)
    time.sleep(0.0 if while_writing else delay)
    process.send_signal(signal.SIGKILL)
    process.wait(PATIENCE)
    return any((run / "resume").glob("*.part"))


def test_runs_that_are_killed_come_out_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    draws = random.Random(0)
    killed = writing = equal = most_lost = 0
    failures: list[str] = []
    for seed in range(RUNS):
        unbroken, run = tmp_path / f"unbroken_{seed}", tmp_path / f"killed_{seed}"
        finish(train(*WORDS, f"seed={100 + seed}", f"run_dir={unbroken}"))
        arguments = [*WORDS, f"seed={100 + seed}", f"run_dir={run}"]
        for number, step in enumerate(sorted(draws.sample(range(STEPS - 300), KILLS))):
            process = train(*arguments)
            while not (run / "config.yaml").exists() and process.poll() is None:
                time.sleep(0.01)
            was_writing = kill(process, run, step, number == seed % KILLS, draws.uniform(0, 2))
            killed, writing = killed + (process.returncode == -signal.SIGKILL), writing + was_writing
            most_lost = max(most_lost, logged_step(run) - kept_step(run))
            arguments = [f"resume={run}"]
        finish(train(*arguments))
        try:
            assert_same_run(unbroken, run, KILLS)
            equal += 1
        except AssertionError as error:
            failures.append(f"seed {100 + seed}: {repr(error)[:200]}")
    with capsys.disabled():
        print(
            f"\nkilled {killed} times, {writing} of them while it wrote a checkpoint: {equal} of {RUNS} runs equal the "
            f"unbroken ones (bar: all); at most {most_lost} logged steps made again (bar: {EVERY})"
        )
    assert not failures
    assert killed == RUNS * KILLS
    assert most_lost <= EVERY
