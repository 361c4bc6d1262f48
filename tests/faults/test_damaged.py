"""100 random damages to a checkpoint: 2 minutes, 20 s with ASDDPG_FAULTS=0.1.

Bars: 100 recognised, each told in a sentence, the one before is used; 0 wrong results.
"""

import random
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from asddpg import train
from asddpg.runs import state_files
from asddpg.runs.rewind import check_logs
from asddpg.runs.training_states import TrainingStates
from tests.faults.scale import scaled
from tests.support.small_runs import QUICK, assert_same_run, assert_same_tree, stopped

pytestmark = pytest.mark.faults

COUNT = scaled(100)
FILES = (state_files.STATE, state_files.ARRAYS, state_files.SUMS)
RESUMED_EACH = 10  # every so many damaged runs are resumed and compared with the unbroken one


def truncate(path: Path, draws: random.Random) -> None:
    path.write_bytes(path.read_bytes()[: draws.randrange(path.stat().st_size)])


def flip(path: Path, draws: random.Random) -> None:
    content = bytearray(path.read_bytes())
    content[draws.randrange(len(content))] ^= 1 << draws.randrange(8)
    path.write_bytes(content)


def zero(path: Path, draws: random.Random) -> None:
    content = bytearray(path.read_bytes())
    begin = draws.randrange(len(content))
    content[begin : begin + 4096] = bytes(len(content[begin : begin + 4096]))
    path.write_bytes(content)


def append(path: Path, draws: random.Random) -> None:
    path.write_bytes(path.read_bytes() + draws.randbytes(draws.randrange(1, 100)))


def remove(path: Path, _: random.Random) -> None:
    path.unlink()


def swap_within(path: Path, draws: random.Random) -> None:
    other = path.with_name(draws.choice([name for name in FILES if name != path.name]))
    content = path.read_bytes()
    path.write_bytes(other.read_bytes())
    other.write_bytes(content)


def swap_with_the_one_before(path: Path, _: random.Random) -> None:
    shutil.copy(path.parent.parent / "step_00000100" / path.name, path)


MUTATIONS: tuple[Callable[[Path, random.Random], None], ...] = (
    truncate, flip, flip, zero, append, remove, swap_within, swap_with_the_one_before,
)  # fmt: skip


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_every_damage_is_recognised(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    draws = random.Random(1)
    unbroken, template = tmp_path / "unbroken", tmp_path / "template"
    train.main([*QUICK, f"run_dir={unbroken}"])
    stopped([*QUICK, f"run_dir={template}"], 135)
    whole = contents(template / "resume/step_00000135")
    before = state_files.read(template / "resume/step_00000100")
    recognised = clear = resumed = wrong = 0
    for number in range(COUNT):
        run = tmp_path / "run"
        shutil.copytree(template, run)
        folder = run / "resume/step_00000135"
        while contents(folder) == whole:  # zeros may be where zeros were
            draws.choice(MUTATIONS)(folder / draws.choice(FILES), draws)
        state, sentences = TrainingStates(run / "resume").newest(
            lambda each, run=run: check_logs(run, each["files"])  # type: ignore[misc]
        )
        assert state is not None
        recognised += len(sentences) == 1
        clear += any("step_00000135 is damaged: " in line and "\n" not in line for line in sentences)
        assert_same_tree(before, state, "state")
        if number % RESUMED_EACH == 0:
            train.main([f"resume={run}"])
            resumed += 1
            try:
                assert_same_run(unbroken, run)
            except AssertionError:
                wrong += 1
        shutil.rmtree(run)
    capsys.readouterr()
    with capsys.disabled():
        print(
            f"\n{recognised} of {COUNT} damages recognised, {clear} told in a sentence (bar: all); "
            f"{wrong} wrong results of {resumed} runs that went on from the checkpoint before (bar: 0)"
        )
    assert (recognised, clear, wrong) == (COUNT, COUNT, 0)
