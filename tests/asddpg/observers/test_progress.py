"""The progress bar, as it is read on a terminal and in a cluster's log."""

import io

import numpy as np
import pytest

from asddpg.episodes.protocols import Decision, Driver, Step
from asddpg.observers.progress import ProgressBar
from tests.support.one_agent import steps_of

SECONDS_A_STEP = 0.1
STEPS = 600
ZEROS = np.zeros(2, dtype=np.float32)
STEPS_MADE = steps_of(Step(ZEROS, Decision(ZEROS, Driver.POLICY), 0.0, ZEROS, False, False, {}))


@pytest.mark.parametrize(("is_terminal", "states"), [(False, 6), (True, 120)], ids=["file", "terminal"])
def test_a_log_file_gets_a_state_every_ten_seconds_and_a_terminal_two_a_second(
    is_terminal: bool, states: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps_done, stream = 0, io.StringIO()
    monkeypatch.setattr("os.isatty", lambda _: is_terminal)
    monkeypatch.setattr("tqdm.std.time", lambda: steps_done * SECONDS_A_STEP)
    monkeypatch.setattr("sys.stderr", stream)
    bar = ProgressBar(STEPS)
    for _ in range(STEPS):
        steps_done += 1
        bar.step(STEPS_MADE, ())
    bar.close()
    assert states / 2 <= stream.getvalue().count("\r") <= states + 2
