"""Runs a recorded episode again: its actions give its physical states to the last bit."""

import functools
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from asddpg.build import make_environment, navigation_env
from asddpg.config import TrainConfig
from asddpg.episodes.protocols import Action
from asddpg.errors import UserError
from asddpg.messages import ERR, print_line
from asddpg.recording.files.reading import Recording
from asddpg.recording.messages.path_message import DRIVER_COLOURS
from asddpg.recording.pictures.caption import OUTCOME_COLOURS, Colour
from asddpg.recording.samples import to_nanoseconds
from asddpg.runs.run_folder import parse_training
from tasks.gymnasium_api.navigation_env import NavigationEnv

StepRecord = dict[str, Any]  # a message of /step
RUNNING = "running"


class RerunStep(NamedTuple):
    """A step that was run again."""

    made: int  # steps so far
    record: StepRecord | None  # the last step; None at the beginning
    outcome: str  # of the environment
    is_same: bool  # the physical state equals the recorded one to the last bit


class EpisodeStates:
    """Runs an episode again.

    Attributes:
        config: of the recorded run.
        environment: in the present state of the iteration.
        steps: the recorded messages of /step.
        outcome: how the episode ended; running where the recording was interrupted.
    """

    def __init__(self, recording: Recording) -> None:
        """Build the environment of a recording.

        Raises:
            UserError: the recording is damaged, or of a version with other options or tasks.
        """
        self.recording = recording
        try:
            self.config, self._physical = _open_environment(recording.config)
        except UserError as error:
            raise UserError(f"{recording.path} cannot be run again: {error}") from error
        self.environment: NavigationEnv = navigation_env(self._physical)
        self.steps = recording.steps()
        self.outcome = str(recording.outcome()["outcome"])

    @property
    def physics(self) -> Any:
        """The scene, as it stands."""
        return self.environment.physics

    def time(self, count: int) -> float:
        """Simulated seconds after so many steps."""
        return count * self.config.task.control_timestep

    def caption(self, count: int, step: StepRecord | None) -> tuple[str, Colour | None]:
        """A line on the state after so many steps, and the colour of the driver or the outcome."""
        facts = self.recording.facts
        text = f"{facts['task']}, episode {int(facts['episode'])} · step {count}, {self.time(count):.1f} s"
        if count == len(self.steps):
            return f"{text} · {self.outcome}", OUTCOME_COLOURS.get(self.outcome)
        if step is None:
            return f"{text} · start", None
        return f"{text} · {step['driver']} drives", DRIVER_COLOURS.get(step["driver"])

    def run(self) -> Iterator[RerunStep]:
        """Run from the beginning, which is 0 steps, to the end.

        Raises:
            UserError: a step of the recording lacks action or digest.
        """
        self._physical.reset(options=self.recording.reset_options)
        yield RerunStep(0, None, RUNNING, is_same=True)
        goals, begin = self.recording.goals(), 0
        for count, step in enumerate(self.steps, 1):
            action, digest = self._read_action(step, count - 1)
            goal, begin = goals.get(begin), to_nanoseconds(step["time"])
            if goal is not None:
                self.environment.set_goal(*goal)
            *_, info = self._physical.step(action)
            is_same = self.physics.state_digest() == digest
            yield RerunStep(count, step, info.get("outcome", RUNNING), is_same)

    def __iter__(self) -> Iterator[tuple[int, StepRecord | None]]:
        """From the beginning, 0 and None, to the end: how many steps have been made, and the last of them."""
        was_same = True
        for count, step, _, is_same in self.run():
            if was_same and not is_same:
                was_same = False
                name = self.recording.path.name
                cause = "it was made on another machine or with other versions"
                print_line(f"note: run again, {name} goes another way from step {count} on: {cause}", ERR)
            yield count, step

    def _read_action(self, step: StepRecord, number: int) -> tuple[Action, int]:
        """The action of a step and the digest after it."""
        try:
            action = np.array([step["action"]["v"], step["action"]["omega"]], dtype=np.float32)
            return action, int(step["digest"])
        except (KeyError, TypeError, ValueError) as error:
            path = self.recording.path
            raise UserError(f"step {number} of {path} has no action (v, omega) or no digest") from error

    def go_to(self, count: int, on_state: Callable[[], object] = lambda: None) -> StepRecord | None:
        """Run up to the end of that many steps, calling `on_state` in each state, and return the last step."""
        for reached, step in self:
            on_state()
            if reached == count:
                return step
        length = f"{len(self.steps)} steps, {self.time(len(self.steps)):.1f} s"
        raise UserError(f"the episode in {self.recording.path} has {length}; there is no step {count}")


@functools.lru_cache(maxsize=1)  # the episodes of a folder are of one room, and opening the office takes a second
def _open_environment(settings: str) -> tuple[TrainConfig, gymnasium.Env]:
    """A recording's configuration, and its environment."""
    config, _ = parse_training(settings, "its configuration", controller=None)
    environment = make_environment(config.task, config.reward)
    navigation_env(environment).set_safety_margin(config.safety_margin)
    return config, environment
