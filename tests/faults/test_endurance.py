"""300,000 steps with a small buffer: 12 minutes on an idle core, 1 with ASDDPG_FAULTS=0.07.

Bars: resident memory after 50,000 steps and at the end within 2 %; as many file handles.
"""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from asddpg.observers.metrics_log import read_rows
from tests.faults.scale import scaled

pytestmark = pytest.mark.faults

STEPS = scaled(300_000, least=12_000)
BEGIN, WINDOW = STEPS // 6, max(STEPS // 60, 1000)  # steps: where it is looked first, and for how long
WORDS = ["task=nav_empty", "network.widths=[16,16]", "network.convolutions=none", "agent.batch_size=8"]
WORDS += [f"total_steps={STEPS}", "agent.buffer_size=2000", "agent.learning_starts=100", "checkpoint_every=1000"]
WORDS += ["validation.every=2500", "validation.episodes=2", "validation.snapshots=false", "test_episodes=0"]
WORDS += ["record.every=10", "record.keep=20"]


def resident(process: int) -> int:
    """kB."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS"))


def test_a_long_run_does_not_grow(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = tmp_path / "run"
    program = [sys.executable, "-m", "asddpg.train", *WORDS, f"run_dir={run}"]
    process = subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    seen: list[tuple[int, int, int]] = []  # step, kB, handles
    while process.poll() is None:
        try:
            handles = len(list(Path(f"/proc/{process.pid}/fd").iterdir()))
            memory = resident(process.pid)
        except (OSError, StopIteration):  # it has just ended
            break
        rows = read_rows(run / "metrics.csv")
        seen.append((int(rows[-1]["step"]) if rows else 0, memory, handles))
        time.sleep(min(0.2, len(rows) / 1e4))
    assert process.wait(60) == 0
    first = [each for each in seen if BEGIN <= each[0] < BEGIN + WINDOW]
    last = [each for each in seen if each[0] >= STEPS - WINDOW]
    assert first
    assert last
    # Medians: a checkpoint in the making has its own.
    before, after = (float(np.median([memory for _, memory, _ in part])) for part in (first, last))
    handles_before, handles_after = (int(np.median([count for *_, count in part])) for part in (first, last))
    growth = after / before - 1
    with capsys.disabled():
        print(
            f"\n{before / 1024:.1f} MB after {BEGIN} steps, {after / 1024:.1f} MB after {STEPS}: {growth:+.2%} "
            f"(bar: within 2 %); {handles_before} and {handles_after} file handles (bar: equal)"
        )
    assert abs(growth) < 0.02
    assert handles_before == handles_after
