"""Drives several cases at once, each in a process of its own."""

import multiprocessing
import signal
import sys
import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from asddpg.build import prepare_torch
from asddpg.errors import UserError
from asddpg.messages import print_line
from tasks.errors import TaskError
from tools.comparison.cases import Case
from tools.comparison.driving import drive

PATIENCE = 5.0  # seconds that a process gets to end by itself


@dataclass(frozen=True)
class _Worker:
    """A process that drives a case, and where it says why it cannot."""

    case: Case
    process: BaseProcess
    failure: Connection
    begun: float  # on the monotonic clock, seconds

    def report(self, count: str) -> None:
        """Print that it has ended; UserError where it failed."""
        if self.process.exitcode:
            raise UserError(f"{self.case.driver} on {self.case.task} was not driven: {self._sentence()}")
        _print_driven(self.case, self.begun, count)

    def _sentence(self) -> str:
        try:
            return str(self.failure.recv())
        except EOFError:
            return f"its process ended with status {self.process.exitcode}"


def drive_all(cases: Sequence[Case], folder: Path, at_once: int) -> None:
    """Drive cases, as many at once; with one at once in this process. An end of any kind ends the others.

    Raises:
        UserError: one of them failed.
    """
    if at_once == 1:
        for number, case in enumerate(cases, 1):
            begun = time.monotonic()
            drive(case, folder)
            _print_driven(case, begun, f"{number} of {len(cases)}")
        return
    waiting, running = deque(cases), list[_Worker]()
    try:
        while waiting or running:
            while waiting and len(running) < at_once:
                running.append(_start(waiting.popleft(), folder))
            wait([worker.process.sentinel for worker in running])
            for worker in [worker for worker in running if not worker.process.is_alive()]:
                running.remove(worker)
                worker.report(f"{len(cases) - len(waiting) - len(running)} of {len(cases)}")
    finally:
        _stop([worker.process for worker in running])


def _print_driven(case: Case, begun: float, count: str) -> None:
    took = time.monotonic() - begun
    print_line(f"{case.driver} on {case.task}: {case.episodes} episodes in {took:.0f} s ({count})")


def _start(case: Case, folder: Path) -> _Worker:
    context = multiprocessing.get_context("spawn")
    failure, sender = context.Pipe(duplex=False)
    process = context.Process(target=_drive_in_process, args=(case, folder, sender), daemon=True)
    with _ignoring_interrupts():
        process.start()
    sender.close()
    return _Worker(case, process, failure, time.monotonic())


@contextmanager
def _ignoring_interrupts() -> Iterator[None]:
    """A process begun here inherits it: Ctrl-C, which a terminal sends to all, ends it through this one alone."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@prepare_torch()
def _drive_in_process(case: Case, folder: Path, failure: Connection) -> None:
    try:
        drive(case, folder)
    except (UserError, TaskError, OSError) as error:
        failure.send(str(error))
        sys.exit(1)


def _stop(processes: Iterable[BaseProcess]) -> None:
    for process in processes:
        process.terminate()
    for process in processes:
        process.join(PATIENCE)
        if process.is_alive():
            process.kill()
            process.join()
