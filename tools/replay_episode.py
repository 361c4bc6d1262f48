"""Does a recorded episode happen again? `python -m tools.replay_episode runs/mine/episodes`.

Runs the recorded actions in the recorded configuration, from the same start to the same goal, and compares the physical
state after each step, to the last bit. The exit status is 1 if any differs,
2 if any cannot be run again.
"""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from asddpg.build import make_environment, navigation_env
from asddpg.episodes.protocols import Action
from asddpg.errors import UserError
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.recording.files.reading import Recording, open_recording
from asddpg.recording.samples import NANOSECONDS
from asddpg.runs.provenance import environment_hash
from asddpg.runs.run_folder import training_in
from tasks.errors import TaskError
from tasks.options import argument
from tools.recordings.files import files_named

RUNNING = "running"
OPEN_ENDS = ("cut", RUNNING)  # outcomes of recordings that do not tell how the episode ended


@dataclass(frozen=True)
class ReplayArguments:
    """The recordings to run again."""

    recordings: list[Path] = argument("Recordings, or folders of them.")


class ReplayResult(NamedTuple):
    """What became of a recording, run again."""

    steps: int  # of the recording
    outcome: str  # as recorded
    difference: str  # in a sentence; empty if there is none


def replay(recording: Recording) -> ReplayResult:
    """Run a recording again.

    Raises:
        UserError: it is damaged, of another version, of another scene, or without steps.
    """
    steps = recording.steps()
    if not steps:
        raise UserError(f"{recording.path} has no steps to run again")
    recorded = recording.outcome()["outcome"]
    return ReplayResult(len(steps), recorded, _difference(recording, steps, recorded))


def _difference(recording: Recording, steps: Sequence[Mapping[str, Any]], recorded: str) -> str:
    environment = _environment_of(recording)
    outcome, goals = RUNNING, recording.goals()
    for number, step in enumerate(steps):
        if outcome != RUNNING:
            return f"{outcome} after {number} steps, the recording has {len(steps)}"
        action, digest = _recorded(step, number, recording)
        goal = goals.get(round(step["time"] * NANOSECONDS))
        if goal is not None:
            navigation_env(environment).set_goal(*goal)
        *_, info = environment.step(action)
        outcome = info.get("outcome", RUNNING)
        if navigation_env(environment).physics.state_digest() != digest:
            return f"the first to differ is step {number} (from 0) of {len(steps)}{_versions(recording.facts)}"
    return "" if recorded in (outcome, *OPEN_ENDS) else f"{outcome} in the end, {recorded} in the recording"


def _environment_of(recording: Recording) -> gymnasium.Env:
    """The recorded environment at the recorded beginning."""
    try:
        environment, scene = _environment(recording.config)
    except UserError as error:
        raise UserError(f"{recording.path} cannot be run again: {error}") from error
    if recording.facts.get("model_hash") != scene:
        raise UserError(
            f"the scene of {recording.path} has changed since, so the episode cannot happen again as it was"
        )
    environment.reset(options={"start": recording.start, "goal": recording.goal})
    return environment


@lru_cache(maxsize=8)
def _environment(config: str) -> tuple[gymnasium.Env, str]:
    """The environment of a configuration, and its scene's hash; the recordings of one run share it."""
    training, _ = training_in(config, "its configuration", controller=None)
    environment = make_environment(training.task, training.reward)
    return environment, environment_hash(environment)


def _recorded(step: Mapping[str, Any], number: int, recording: Recording) -> tuple[Action, int]:
    """The action of a step and the digest after it."""
    try:
        action = np.array([step["action"]["v"], step["action"]["omega"]], dtype=np.float32)
        return action, int(step["digest"])
    except (KeyError, TypeError, ValueError) as error:
        raise UserError(f"step {number} of {recording.path} has no action (v, omega) or no digest") from error


def _versions(facts: Mapping[str, str]) -> str:
    """That MuJoCo is another, which changes the last bits."""
    recorded, present = facts.get("mujoco"), metadata.version("mujoco")
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
            print(f"error: {error}", file=sys.stderr, flush=True)
            status = status or 2
            continue
        same = f"the same to the last bit over {found.steps} steps, {found.outcome}"
        print(f"{path}: {found.difference or same}", flush=True)
        status = 1 if found.difference else status
    if status:
        sys.exit(status)


if __name__ == "__main__":
    run(main, help_text(__doc__, ReplayArguments))
