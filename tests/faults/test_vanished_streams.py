"""20 runs that lose standard output, standard error, both or their terminal at a random moment: 5 minutes.

Bar: 20 of 20 end as the unbroken run, or resume to its bits. 1 minute with ASDDPG_FAULTS=0.2.
"""

import contextlib
import os
import pty
import random
import subprocess
import sys
import time
from pathlib import Path

import pytest

from asddpg import train
from tests.faults.scale import scaled
from tests.support.small_runs import QUICK, assert_same_run

pytestmark = pytest.mark.faults

RUNS, PATIENCE = scaled(20), 300.0  # s
LOST = (("stdout", os.pipe), ("stderr", os.pipe), ("stdout stderr", os.pipe), ("stdout stderr", pty.openpty))


def run_and_lose(run: Path, number: int, delay: float) -> tuple[int, float]:
    """Train until the reader of some streams goes; exit status and duration."""
    lost, make = LOST[number % len(LOST)]
    read, write = make()
    out, err = (write if name in lost else subprocess.DEVNULL for name in ("stdout", "stderr"))
    words = [*QUICK, "total_steps=1000", "validation.every=200", "checkpoint_every=300", f"run_dir={run}"]
    begun = time.monotonic()
    with subprocess.Popen([sys.executable, "-m", "asddpg.train", *words], stdout=out, stderr=err) as process:
        os.close(write)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(delay)
        os.close(read)
        return process.wait(PATIENCE), time.monotonic() - begun


def test_runs_that_lose_their_streams_come_out_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    draws, statuses = random.Random(0), list[int]()
    _, longest = run_and_lose(tmp_path / "unbroken", 0, PATIENCE)
    for number in range(RUNS):
        run = tmp_path / f"run_{number}"
        statuses.append(run_and_lose(run, number, draws.uniform(0, longest))[0])
        if not (run / "resources.json").exists():
            train.main([f"resume={run}"])
        assert_same_run(tmp_path / "unbroken", run)
    capsys.readouterr()
    with capsys.disabled():
        ended = f"{statuses.count(0)} ended, {statuses.count(129)} stopped and resumed"
        print(f"\n{len(statuses)} of {RUNS} runs that lost their streams equal the unbroken one (bar: all): {ended}")
    assert set(statuses) <= {0, 129}
