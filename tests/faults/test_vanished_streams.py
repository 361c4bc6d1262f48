"""20 runs that lose standard output, standard error, both or their terminal at a random moment: 3 minutes.

Bar: 20 of 20 end as the unbroken run, or resume to its bits. 20 s with ASDDPG_FAULTS=0.1.
"""

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
WORDS = [*QUICK, "total_steps=1000", "validation.every=200", "checkpoint_every=300"]
LOST = (("stdout",), ("stderr",), ("stdout", "stderr"), ("stdout", "stderr"))


def start(run: Path, lost: tuple[str, ...], number: int) -> tuple[subprocess.Popen[bytes], int]:
    """A training, and the end of a pipe or of a terminal that these streams of it are read from."""
    read, write = pty.openpty() if number % len(LOST) == len(LOST) - 1 else os.pipe()
    out, err = (write if name in lost else subprocess.DEVNULL for name in ("stdout", "stderr"))
    arguments = [sys.executable, "-m", "asddpg.train", *WORDS, f"run_dir={run}"]
    process = subprocess.Popen(arguments, stdout=out, stderr=err)
    os.close(write)
    return process, read


def test_runs_that_lose_their_streams_come_out_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    draws, statuses, equal = random.Random(0), list[int](), 0
    process, read = start(tmp_path / "unbroken", (), 0)
    begun = time.monotonic()
    assert process.wait(PATIENCE) == 0
    longest = time.monotonic() - begun
    for number in range(RUNS):
        run = tmp_path / f"run_{number}"
        process, read = start(run, LOST[number % len(LOST)], number)
        time.sleep(draws.uniform(0, longest))
        os.close(read)
        statuses.append(process.wait(PATIENCE))
        if not (run / "resources.json").exists():
            train.main([f"resume={run}"])
        assert_same_run(tmp_path / "unbroken", run)
        equal += 1
    capsys.readouterr()
    with capsys.disabled():
        ended = f"{statuses.count(0)} ended, {statuses.count(129)} stopped and resumed"
        print(f"\n{equal} of {RUNS} runs that lost their streams equal the unbroken one (bar: all): {ended}")
    assert set(statuses) <= {0, 129}
