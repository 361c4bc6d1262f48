"""How a program of this package begins and ends."""

import os
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

from dm_control.rl.control import PhysicsError

from asddpg.errors import NumericalFailure, UserError
from tasks.errors import TaskError


def python() -> str:
    """How the user calls this Python: by its path below the present folder, as in .venv, or by name."""
    path = Path(sys.executable)
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else "python"


def run(main: Callable[[Sequence[str]], None], usage: str) -> None:
    """Run `main` on the command line's arguments; a user's mistake is one sentence and exit status 2."""
    arguments = sys.argv[1:]
    if any(argument in ("-h", "--help") for argument in arguments):
        main, arguments = (lambda _: print(usage)), []
    _end_on_sigterm()
    try:
        main(arguments)
        sys.stdout.flush()
    except BrokenPipeError:  # whoever read along, such as head, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except (UserError, TaskError) as error:
        _fail(str(error), 2)
    except NumericalFailure as error:
        _fail(str(error), 1)
    except PhysicsError as error:
        _fail(f"the simulation broke down, most likely by an action that is not finite: {error}", 1)
    except OSError as error:  # a full disk, a folder that is not writable
        _fail(f"{error.filename or 'a file'} cannot be read or written: {error.strerror or error}", 2)
    except MemoryError as error:
        _fail(f"the memory of this machine is not enough: {error}", 2)
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        sys.exit(130)


def _fail(sentence: str, status: int) -> NoReturn:
    """Print an error in one line and exit; text from a user or a file may break no line and steer no terminal."""
    line = "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in sentence)
    print(f"error: {line}", file=sys.stderr)
    sys.exit(status)


def _end_on_sigterm() -> None:
    """Let SIGTERM end the program like an error: files in progress are completed, the status is 143."""

    def end(number: int, _: object) -> None:
        sys.exit(128 + number)

    signal.signal(signal.SIGTERM, end)
