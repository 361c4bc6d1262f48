"""How a program of this package begins and ends."""

import io
import os
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

from dm_control.rl.control import PhysicsError

from asddpg.errors import NumericalFailure, UserError
from asddpg.messages import ERR, OUT, is_gone, print_line
from tasks.errors import TaskError


def python() -> str:
    """How the user calls this Python: by its path below the present folder, as in .venv, or by name."""
    with suppress(OSError, ValueError):  # the present folder is gone, or Python lies elsewhere
        return str(Path(sys.executable or "python").relative_to(Path.cwd()))
    return "python"


def run(main: Callable[[Sequence[str]], None], usage: str) -> None:
    """Run `main` on the command line's arguments; a user's mistake is one sentence and exit status 2."""
    arguments = sys.argv[1:]
    if any(argument in ("-h", "--help") for argument in arguments):
        main, arguments = (lambda _: print(usage)), []
    _end_on_signals()
    _prepare_streams()
    try:
        main(arguments)
        print(end="", flush=not OUT.is_broken)  # unless its reader is gone
    except (UserError, TaskError) as error:
        _fail(str(error), 2)
    except NumericalFailure as error:
        _fail(str(error), 1)
    except PhysicsError as error:
        _fail(f"the simulation broke down, most likely by an action that is not finite: {error}", 1)
    except OSError as error:  # a full disk, a folder that is not writable
        if error.filename is None and is_gone(error):  # the reader is gone, such as head
            sys.exit(1)
        _fail(f"{error.filename or 'a file or a stream'} cannot be read or written: {error.strerror or error}", 2)
    except MemoryError as error:
        _fail(f"the memory of this machine is not enough: {error}", 2)
    except KeyboardInterrupt:
        print_line("stopped", ERR)
        sys.exit(130)
    finally:
        _drop_unwritten()


def _fail(sentence: str, status: int) -> NoReturn:
    """Print an error in one line and exit; text from a user or a file may break no line and steer no terminal."""
    line = "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in sentence)
    print_line(f"error: {line}", ERR)
    sys.exit(status)


def _end_on_signals() -> None:
    """Let SIGTERM and SIGHUP end the program like an error: files are completed, the status is 143 or 129."""

    def end(number: int, _: object) -> None:
        sys.exit(128 + number)

    for number in (signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):  # Windows has no SIGHUP
        if signal.getsignal(number) == signal.SIG_DFL:  # and not ignored, as under nohup
            signal.signal(number, end)


def _prepare_streams() -> None:
    """Escape what standard output or error cannot encode; where one is closed, no file may come into its place."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) < 3:  # which takes the lowest number that is free
        pass
    os.close(descriptor)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _drop_unwritten() -> None:
    """Drop what a broken stream still keeps: the interpreter would end with a traceback and status 120."""
    for stream in (sys.stdout, sys.stderr):
        try:
            print(end="", file=stream, flush=True)
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
