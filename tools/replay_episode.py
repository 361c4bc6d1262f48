"""Run recorded episodes again: `python -m tools.replay_episode runs/mine/episodes`.

Runs the recorded actions in the recorded configuration, from the same start to the same goal, and compares the physical
state after each step, to the last bit. The exit status is 1 if any differs, 2 if any cannot be run again.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

from asddpg.errors import UserError
from asddpg.messages import ERR, print_line
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.recording.files.reading import Recording, open_recording
from asddpg.runs.provenance import environment_hash
from tasks.errors import TaskError
from tasks.options import argument
from tools.recordings.episode_states import RUNNING, EpisodeStates
from tools.recordings.files import files_named

OPEN_ENDS = ("cut", RUNNING)  # outcomes of recordings that end before their episode


@dataclass(frozen=True)
class ReplayArguments:
    """The recordings to run again."""

    recordings: list[Path] = argument("Recordings, or folders of them.")


class ReplayResult(NamedTuple):
    """How a recording compares with its episode run again."""

    steps: int  # of the recording
    outcome: str  # as recorded
    difference: str  # in a sentence; empty if there is none


def replay(recording: Recording) -> ReplayResult:
    """Run a recording again.

    Raises:
        UserError: it is damaged, of another version, of another scene, or without steps.
    """
    states = EpisodeStates(recording)
    if not states.steps:
        raise UserError(f"{recording.path} has no steps to run again")
    if recording.facts.get("model_hash") != environment_hash(states.environment):
        raise UserError(f"the scene of {recording.path} has changed since, so its episode cannot be run again")
    return ReplayResult(len(states.steps), states.outcome, _find_difference(states))


def _find_difference(states: EpisodeStates) -> str:
    length, outcome = len(states.steps), RUNNING
    for count, _, outcome, is_same in states.run():
        if not is_same:
            return f"the first to differ is step {count - 1} (from 0) of {length}{_compare_versions(states.recording)}"
        if outcome != RUNNING and count < length:
            return f"{outcome} after {count} steps, the recording has {length}"
    # A mission ends where its robot believes to be at the last target, which the environment does not know.
    is_mission = outcome == RUNNING and states.config.task.goal_radius == 0.0
    ends = (outcome, *OPEN_ENDS, *(("reached", "timeout") if is_mission else ()))
    if states.outcome in ends:
        return ""
    return f"{outcome} in the end, {states.outcome} in the recording"


def _compare_versions(recording: Recording) -> str:
    """That MuJoCo has another version, which changes the last bits."""
    recorded, present = recording.facts.get("mujoco"), metadata.version("mujoco")
    return "" if recorded == present else f"; it was made with mujoco {recorded}, this is {present}"


def main(arguments: Sequence[str]) -> None:
    """Run all again, a line each."""
    files = files_named(parse_arguments(ReplayArguments, arguments).recordings)
    status = 0
    for path in files:
        try:
            found = replay(open_recording(path))
        except (UserError, TaskError) as error:
            if len(files) == 1:
                raise
            print_line(f"error: {error}", ERR)
            status = status or 2
            continue
        same = f"the same to the last bit over {found.steps} steps, {found.outcome}"
        print(f"{path}: {found.difference or same}", flush=True)
        status = 1 if found.difference else status
    if status:
        sys.exit(status)


if __name__ == "__main__":
    run(main, help_text(__doc__, ReplayArguments))
