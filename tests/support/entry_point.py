"""Runs a program in this process as a shell does: arguments in, status and stderr out."""

import contextlib
import io
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from asddpg.program import run

FOUND = ("a_file", "full", "full/precious")  # what lies in the folder beforehand


class Ended(NamedTuple):
    """How a program ended."""

    status: object
    said: str  # on stderr
    made: list[str]  # below the working folder


def ended(main: Callable[[Sequence[str]], None], arguments: Sequence[str]) -> Ended:
    """Run a program to its end in a folder of its own, with a file and a folder that is not empty."""
    err = io.StringIO()
    status: object = 0
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name), _typed(arguments, err):
        arranged(Path(name))
        try:
            run(main, "usage")
        except SystemExit as error:
            status = error.code
        return Ended(status, err.getvalue(), made_in(Path(name)))


def arranged(folder: Path) -> None:
    """Put in place what a program finds."""
    (folder / "full").mkdir()
    (folder / "a_file").touch()
    (folder / "full/precious").touch()


def made_in(folder: Path) -> list[str]:
    """What a program has made."""
    return sorted({str(path.relative_to(folder)) for path in folder.rglob("*")} - set(FOUND))


@contextlib.contextmanager
def _typed(arguments: Sequence[str], err: io.StringIO) -> Iterator[None]:
    """The arguments of a command line, in a shell's place; a program's handlers of signals do not outlive it."""
    argv, handlers = sys.argv, {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    sys.argv = ["program", *arguments]
    try:
        with contextlib.redirect_stderr(err):
            yield
    finally:
        sys.argv = argv
        for number, handler in handlers.items():
            signal.signal(number, handler)
