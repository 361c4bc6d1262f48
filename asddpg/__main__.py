"""The command `asddpg`, or `python -m asddpg`: all programs by name."""

import difflib
import os
import runpy
import sys
from contextlib import suppress

from asddpg import __version__
from asddpg.messages import ERR, print_line

# Program → what it does. `asddpg train` is `python -m asddpg.train`, and so on.
PROGRAMS = {
    "asddpg.train": "train a policy, or resume a training",
    "asddpg.evaluate": "drive the stored test pairs, print the table",
    "asddpg.play": "record episodes, show them live, or make a film",
    "asddpg.mission": "send a robot that localises itself to targets in turn",
    "asddpg.reproduce": "repeat the step at which a training failed",
    "tools.room": "show what becomes of a room of your own",
    "tools.picture": "draw a room or the robot",
    "tools.teleop": "drive by the keyboard",
    "tools.compare": "drive several drivers along the same pairs, in one table",
    "tools.localization": "measure how well the robot localises itself",
    "tools.export": "write a policy as ONNX",
    "tools.publish": "ship a policy with its card",
    "tools.diagnose": "measure and plot what a run has learned",
    "tools.results": "train the runs behind the README",
    "tools.ablation": "train a group of runs, and tabulate it",
    "tools.episodes": "list the episodes of recordings",
    "tools.episode_map": "draw a recorded path from above",
    "tools.episode_plot": "plot a recorded episode over time",
    "tools.episode_frame": "draw an instant of a recorded episode",
    "tools.contact_sheet": "draw a recorded episode in several pictures",
    "tools.replay_episode": "run a recorded episode again",
    "tools.recover": "repair a recording that was cut off",
    "tools.robot_figures": "measure a robot",
    "tools.bench": "measure the speed of environment and training",
}
_NAMES = {program.rpartition(".")[2]: program for program in PROGRAMS}


def main() -> None:
    """Run the program that the first argument names, on the arguments after it."""
    name, arguments = (sys.argv[1], sys.argv[2:]) if len(sys.argv) > 1 else ("help", [])
    if name in ("help", "-h", "--help"):
        print_line(_usage())
    elif name in ("version", "-V", "--version"):
        print_line(f"asddpg {__version__}")
    elif name not in _NAMES:
        print_line(f"error: {_unknown(name)}", ERR)
        sys.exit(2)
    else:
        _find_users_files()
        sys.argv = [f"asddpg {name}", *arguments]
        runpy.run_module(_NAMES[name], run_name="__main__", alter_sys=True)


def _usage() -> str:
    width = max(map(len, _NAMES))
    lines = [f"  {name:{width}}  {PROGRAMS[program]}" for name, program in _NAMES.items()]
    return "\n".join(
        ["asddpg PROGRAM OPTION=VALUE …, such as asddpg train task=nav_empty", "", *lines, "", "asddpg PROGRAM --help"]
    )


def _unknown(name: str) -> str:
    alike = difflib.get_close_matches(name, _NAMES, n=1, cutoff=0.7)
    known = f"did you mean {alike[0]}?" if alike else f"there are {', '.join(_NAMES)}"
    return f"there is no program {name!r}; {known}"


def _find_users_files() -> None:
    """Let package.module:Factory be found in the present folder, after all else, as by `python -m`."""
    with suppress(OSError):  # the folder is gone
        if not sys.flags.safe_path and os.getcwd() not in sys.path:
            sys.path.append(os.getcwd())


if __name__ == "__main__":
    main()
