"""Trains runs, two at a time, each in a process of its own."""

import fcntl
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from asddpg.errors import UserError
from asddpg.runs.safe_loading import CONTROLLER
from tools.experiments.run_groups import Run
from tools.experiments.run_store import archive_existing, is_begun

AT_ONCE = 2
LOOK_EVERY = 0.2  # seconds
PATIENCE = 30.0  # seconds that a process gets to end by itself


@dataclass(frozen=True)
class _Training:
    run: Run
    process: subprocess.Popen[bytes]


def log_of(run: Run, folder: Path) -> Path:
    """Where a run's output is kept."""
    return folder / f"{run.name}.log"


def train(runs: Sequence[Run], folder: Path) -> list[Run]:
    """Train into a folder; those that failed come back, the others are not stopped by them.

    Raises:
        UserError: another program is training into the folder.
        KeyboardInterrupt: the user wants no more; the runs in progress are stopped, the finished ones are kept.
    """
    if not runs:
        return []
    folder.mkdir(parents=True, exist_ok=True)
    with _alone_in(folder) as lock, _signals_as_interrupts():
        return _train(deque(runs), folder, lock)


def _train(waiting: deque[Run], folder: Path, lock: int) -> list[Run]:
    running: list[_Training] = []
    failed: list[Run] = []
    total, ended = len(waiting), 0
    try:
        while waiting or running:
            while waiting and len(running) < AT_ONCE:
                running.append(_start(waiting.popleft(), folder, lock))
            time.sleep(LOOK_EVERY)
            for training in [training for training in running if training.process.poll() is not None]:
                running.remove(training)
                ended += 1
                status = training.process.returncode
                failed += [training.run] if status else []
                print(f"{training.run.name} {how_it_ended(status)} ({ended} of {total})", flush=True)
    finally:
        _stop(running)
    return failed


def _start(run: Run, folder: Path, lock: int) -> _Training:
    path = folder / run.name
    goes_on = is_begun(path, run.settings)
    if not goes_on and (said := archive_existing(path, run.settings)):
        print(said, flush=True)
    with log_of(run, folder).open("ab" if goes_on else "wb") as log:
        # In a session of its own, so that Ctrl-C reaches it once, through _stop.
        # It holds the lock too: should this program be killed, nobody else touches the folder before it has ended.
        arguments = command(run, path, goes_on)
        process = subprocess.Popen(arguments, stdout=log, stderr=log, start_new_session=True, pass_fds=(lock,))
    return _Training(run, process)


def command(run: Run, path: Path, goes_on: bool) -> list[str]:
    """What trains a run, from its beginning or from its last checkpoint."""
    if not goes_on:
        return [sys.executable, "-m", "asddpg.train", *run.arguments, f"run_dir={path}"]
    own = [
        argument for argument in run.arguments if argument.startswith(CONTROLLER)
    ]  # code, which a resumed run wants named
    return [sys.executable, "-m", "asddpg.train", f"resume={path}", *own]


def how_it_ended(status: int) -> str:
    """A process's exit status in words."""
    if status < 0:
        return f"FAILED, stopped by {signal.Signals(-status).name}"
    return f"FAILED with status {status}" if status else "trained"


def _stop(running: Sequence[_Training]) -> None:
    for training in running:
        training.process.send_signal(signal.SIGINT)
    for training in running:
        try:
            training.process.wait(PATIENCE)
        except (subprocess.TimeoutExpired, KeyboardInterrupt):
            training.process.kill()
            training.process.wait()


@contextmanager
def _alone_in(folder: Path) -> Iterator[int]:
    """Two programs in one folder would take each other's unfinished runs for broken off; gives the lock."""
    with (folder / ".lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise UserError(f"another program is training into {folder}; wait for it, or stop it") from error
        yield lock.fileno()


@contextmanager
def _signals_as_interrupts() -> Iterator[None]:
    """Being terminated, or losing the terminal, stops the processes as Ctrl-C does."""
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    for number, handler in before.items():
        if handler != signal.SIG_IGN:  # as under nohup
            signal.signal(number, signal.default_int_handler)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
