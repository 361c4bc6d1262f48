"""A full disk, or a folder that cannot be written: one sentence, whole training states, and a resume."""

import errno
import gc
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asddpg import train
from asddpg.observers.step_log import COLUMNS, StepLog
from asddpg.program import python
from asddpg.runs import state_files
from asddpg.runs.rewind import check_logs
from asddpg.runs.training_states import TrainingStates
from tests.support.small_runs import QUICK, assert_same_run, die, stopped

FULL = "/dev/full"


def assert_checkpoints_whole(run: Path, at_least: int = 0) -> None:
    states = TrainingStates(run / "resume")
    assert len(states.paths()) >= at_least
    _, damaged = states.newest(lambda each: check_logs(run, each["files"]))
    assert not damaged
    assert not list((run / "resume").glob("*.part"))


# One file after the other -----------------------------------------------------------------------------------------

WRITTEN = (
    "metrics.csv", "timing.csv", "validation.csv", "steps.f32", "steps.npz.part", "config.yaml.part",
    "tensorboard/events.out.tfevents.0000000000", "checkpoints/last.safetensors.part",
    "checkpoints/best.safetensors.part", "test.json.part", "resources.json.part",
)  # fmt: skip


@pytest.mark.filterwarnings("error")  # an exception in a thread, or in a destructor, is a warning
@pytest.mark.skipif(not Path(FULL).exists(), reason="there is no /dev/full")
@pytest.mark.parametrize("name", WRITTEN)
def test_no_disk_space_for_a_file(
    name: str, unbroken: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run, path = tmp_path / "run", tmp_path / "run" / name
    monkeypatch.setattr("asddpg.runs.run_folder.check_links", lambda _: None)
    stopped([*QUICK, f"run_dir={run}"], 20, die)  # before the first checkpoint: it begins anew
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    path.symlink_to(FULL)
    with pytest.raises(OSError, match="No space left") as caught:
        train.main([f"resume={run}"])
    del caught
    gc.collect()
    if name != "config.yaml.part":
        assert (
            f"can resume from its last training state: {python()} -m asddpg.train resume={run}"
            in capsys.readouterr().err
        )
    assert_checkpoints_whole(run)
    path.unlink(missing_ok=True)
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


@pytest.mark.parametrize("what", ["Path.write_text", "_write_tensors", "to_disk"])
def test_no_disk_space_for_a_training_state(
    what: str, unbroken: Path, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    real = state_files.write

    def write(folder: Path, tree: Any) -> None:
        if tree["step"] == 150:
            monkeypatch.setattr(f"asddpg.runs.state_files.{what}", full)
        real(folder, tree)

    monkeypatch.setattr(state_files, "write", write)
    with pytest.raises(OSError, match="No space left on device: .*step_00000150") as caught:
        train.main([*QUICK, f"run_dir={run}"])
    assert caught.value.strerror == "No space left on device"
    monkeypatch.undo()
    assert sorted(path.name for path in (run / "resume").iterdir()) == ["step_00000050", "step_00000100"]
    assert_checkpoints_whole(run)
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


def test_a_file_in_the_way_of_the_checkpoints(unbroken: Path, run: Path) -> None:
    stopped([*QUICK, f"run_dir={run}"], 20, die)
    (run / "resume").touch()
    with pytest.raises(OSError, match="step_00000050"):
        train.main([f"resume={run}"])
    (run / "resume").unlink()
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


# Real ones --------------------------------------------------------------------------------------------------------

Mount = Callable[..., Path]


@pytest.fixture
def mount(tmp_path: Path) -> Iterator[Mount]:
    """Mounts something at tmp_path/disk, for as long as the test lasts; skips where one may not."""
    disk = tmp_path / "disk"
    disk.mkdir()
    is_mounted = False

    def act(*arguments: str) -> Path:
        nonlocal is_mounted
        done = subprocess.run(["mount", *arguments, str(disk)], capture_output=True, text=True, check=False)
        if done.returncode:
            pytest.skip(f"nothing can be mounted here: {done.stderr.strip()}")
        is_mounted = True
        return disk

    yield act
    if is_mounted:
        gc.collect()  # a file that is still mapped keeps the disk busy
        subprocess.run(["umount", str(disk)], check=True)


def train_as_a_user(*arguments: str) -> tuple[int, str]:
    """Exit status and what was printed to stderr, without the progress bar."""
    done = subprocess.run(
        [sys.executable, "-m", "asddpg.train", *arguments], capture_output=True, text=True, check=False
    )
    output = [line for line in done.stderr.splitlines() if "steps/s" not in line]
    return done.returncode, "\n".join(output)


@pytest.mark.parametrize("size", ["300k", pytest.param("100k", marks=pytest.mark.slow)])
def test_a_disk_that_fills_up(size: str, unbroken: Path, mount: Mount) -> None:
    run = mount("-t", "tmpfs", "-o", f"size={size}", "tmpfs") / "run"
    status, output = train_as_a_user(*QUICK, f"run_dir={run}")
    assert status == 2
    *recordings, hint, error = [line.strip() for line in output.splitlines() if line.strip()]
    assert all("is not recorded" in line for line in recordings)  # which stops nobody
    assert hint == f"the training can resume from its last training state: {python()} -m asddpg.train resume={run}"
    assert re.fullmatch(rf"error: {run}\S* cannot be read or written: No space left on device", error)
    assert_checkpoints_whole(run)
    mount("-o", "remount,size=100m")
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


def test_a_disk_that_may_only_be_read(tmp_path: Path, mount: Mount) -> None:
    stopped([*QUICK, f"run_dir={tmp_path / 'all/run'}"], 60)
    disk = mount("--bind", str(tmp_path / "all"))
    mount("-o", "remount,bind,ro")
    for arguments in ([f"resume={disk / 'run'}"], [*QUICK, f"run_dir={disk / 'other'}"]):
        status, output = train_as_a_user(*arguments)
        assert status == 2
        assert len(output.splitlines()) == 1
        assert output.startswith("error: ")
        assert "Read-only file system" in output


def test_a_row_that_was_cut_does_not_hide_that_the_disk_is_full(tmp_path: Path) -> None:
    """Long episodes are written past Python's buffer, and so in part."""
    log = StepLog(tmp_path / "steps.f32", tmp_path / "steps.npz")
    log._file.write(np.ones(5 * len(COLUMNS) - 3, dtype=np.float32).tobytes())
    log.close()
    with np.load(tmp_path / "steps.npz") as steps:
        assert {len(steps[name]) for name in COLUMNS} == {4}
