"""How a program of this package begins and ends."""

import sys
from collections.abc import Callable, Sequence

from dm_control.rl.control import PhysicsError

from asddpg.errors import UserError
from tasks.errors import TaskError


def run(main: Callable[[Sequence[str]], None], usage: str) -> None:
    """Run `main` on the command line's words; a user's mistake is one sentence and exit status 2."""
    words = sys.argv[1:]
    if any(word in ("-h", "--help") for word in words):
        print(usage)
        return
    try:
        main(words)
    except (UserError, TaskError) as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
    except PhysicsError as error:
        print(f"error: the simulation broke down, most likely by an action that is no number: {error}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:  # a full disk, a folder that is not writable
        print(f"error: {error.filename or 'a file'} cannot be read or written: {error.strerror}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        sys.exit(130)
