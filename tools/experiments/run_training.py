"""Trains runs, two at a time, each in a process of its own."""

import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from asddpg.atomic_write import take_lock
from asddpg.errors import UserError
from asddpg.messages import print_line
from asddpg.runs.safe_loading import CONTROLLER
from asddpg.runs.signals import StopSignals
from tools.experiments.run_store import archive_existing, can_resume
from tools.experiments.runs import Run

AT_ONCE = 2
LOOK_EVERY = 0.2  # seconds
PATIENCE = 30.0  # seconds that a process gets to end by itself

Process = subprocess.Popen[bytes]


def log_path(run: Run, folder: Path) -> Path:
    """The file that keeps a run's output."""
    return folder / f"{run.name}.log"


def train(runs: Sequence[Run], folder: Path) -> list[Run]:
    """Train into a folder; those that fail come back, and stop none of the others.

    Raises:
        UserError: another program is training into the folder.
        KeyboardInterrupt: Ctrl-C, SIGTERM or a closed terminal; runs in progress are stopped, finished ones are kept.
    """
    print_line(f"{len(runs)} runs to train, {AT_ONCE} at a time; the output of each goes to {folder}/<run>.log")
    if not runs:
        return []
    folder.mkdir(parents=True, exist_ok=True)
    waiting, running, failed = deque(runs), dict[Process, Run](), list[Run]()
    with lock_folder(folder) as lock, StopSignals() as signals:
        try:
            while (waiting or running) and not signals.number:
                while waiting and len(running) < AT_ONCE:
                    run = waiting.popleft()
                    running[start(run, folder, lock)] = run
                time.sleep(LOOK_EVERY)
                for process in [process for process in running if process.poll() is not None]:
                    run = running.pop(process)
                    failed += [run] if process.returncode else []
                    ended = f"{len(runs) - len(waiting) - len(running)} of {len(runs)}"
                    print_line(f"{run.title} {describe_exit(process.returncode)} ({ended})")
        finally:
            _stop(running)
        if signals.number:
            raise KeyboardInterrupt
    return failed


def start(run: Run, folder: Path, lock: int) -> Process:
    """Begin to train a run, or go on; the process holds the folder's lock too, should this one be killed."""
    path = folder / run.name
    resumes = can_resume(run, path)
    if not resumes:
        archive_existing(path)
    with log_path(run, folder).open("ab" if resumes else "wb") as log:
        # In a session of its own, so that Ctrl-C reaches it once, through _stop.
        command = train_command(run, path, resumes)
        return subprocess.Popen(command, stdout=log, stderr=log, start_new_session=True, pass_fds=(lock,))


def train_command(run: Run, path: Path, resumes: bool) -> list[str]:
    """What trains a run, from its beginning or from its last checkpoint."""
    if not resumes:
        return [sys.executable, "-m", "asddpg.train", *run.arguments, f"run_dir={path}"]
    # A resumed run names a controller of its own again: it is code.
    controller = [argument for argument in run.arguments if argument.startswith(CONTROLLER)]
    return [sys.executable, "-m", "asddpg.train", f"resume={path}", *controller]


def describe_exit(status: int) -> str:
    """A process's exit status as text."""
    if status < 0:
        return f"FAILED, stopped by {signal.Signals(-status).name}"
    return f"FAILED with status {status}" if status else "trained"


def _stop(processes: Iterable[Process]) -> None:
    for process in processes:
        process.terminate()  # a shell may have begun this program with SIGINT ignored, which its processes inherit
    for process in processes:
        try:
            process.wait(PATIENCE)
        except (subprocess.TimeoutExpired, KeyboardInterrupt):
            process.kill()
            process.wait()


@contextmanager
def lock_folder(folder: Path) -> Iterator[int]:
    """Two programs in one folder would take each other's unfinished runs for interrupted ones; gives the lock."""
    with (folder / ".lock").open("w") as lock:
        try:
            take_lock(lock)
        except BlockingIOError as error:
            raise UserError(f"another program is training into {folder}; wait for it, or stop it") from error
        yield lock.fileno()
