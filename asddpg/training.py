"""A training: steps until they are used up, validations between episodes, training states after any step."""

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, TypeVar, cast

import numpy as np

from asddpg.algorithm.agent import AsDDPG
from asddpg.build import make_robots
from asddpg.config import TrainConfig
from asddpg.episodes.batch_steps import Float32Array, info_of
from asddpg.episodes.evaluation import EvaluationResult
from asddpg.episodes.finite_check import check_weights
from asddpg.episodes.side_by_side import evaluate_side_by_side
from asddpg.episodes.training_episodes import TrainingEpisodes
from asddpg.errors import UserError
from asddpg.messages import print_line
from asddpg.observers.metrics_log import MetricsLog, read_rows, write_validation
from asddpg.observers.one_robot import OneRobot
from asddpg.observers.progress import ProgressBar
from asddpg.observers.step_log import StepLog
from asddpg.recording.live.live_view import LiveView
from asddpg.recording.pictures.cameras import Cameras
from asddpg.recording.recorder import Provenance, Recorder, Selection, every_nth
from asddpg.runs import failure_dump, weights_file
from asddpg.runs.failure_dump import Failure, first_line
from asddpg.runs.lock import RunLock
from asddpg.runs.rewind import log_lengths
from asddpg.runs.run_folder import RunFolder
from asddpg.runs.safe_loading import controller_argument
from asddpg.runs.signals import Stopped, StopSignals
from asddpg.runs.training_states import TrainingStates
from tasks.evaluation_pairs import stored_pairs
from tasks.gymnasium_api.navigation_vector_env import NavigationVectorEnv

VALIDATION_ROBOTS = 16  # at most, side by side
Closable = TypeVar("Closable", bound=Any)  # with a method close()


@dataclass(frozen=True)
class Parts:
    """What a training is put together from, all of it made before anything is written."""

    config: TrainConfig
    robots: NavigationVectorEnv
    agent: AsDDPG
    cameras: Cameras | None = None
    live: LiveView | None = None


class Training:
    """A training from its beginning, or from a training state, to its end."""

    def __init__(
        self,
        parts: Parts,
        folder: RunFolder,
        lock: RunLock,
        provenance: Provenance,
        state: Mapping[str, Any] | None = None,
    ) -> None:
        """Begin a training, or resume one from a state of TrainingStates; nothing is written yet.

        Raises:
            UserError: the state is of another agent.
        """
        self._parts, self._config, self._folder = parts, parts.config, folder
        self._lock, self._provenance = lock, provenance
        # Others: validating must not disturb the episodes in progress or the stream of their goals.
        self._validation_robots: NavigationVectorEnv | None = None  # made for the first
        self._states = TrainingStates(folder.training_states)
        self._episodes = TrainingEpisodes(parts.robots, parts.agent, self._config.seed)
        self._signals = StopSignals()
        self._validations, self._seconds = 0, 0.0
        self._best: list[float] = []  # success rate and metric, compared in this order
        self._saved_step = 0  # of the newest training state
        self._bar: ProgressBar | None = None
        self._is_validating = False
        self._log_states: Mapping[str, Any] = {}
        if state is not None:
            load_episodes(self._episodes, state)
            self._validations, self._seconds = state["validations"], state["seconds"]
            self._best, self._saved_step, self._log_states = state["best"], state["step"], state["logs"]

    @property
    def step(self) -> int:
        """Training steps made so far."""
        return self._episodes.step

    @property
    def seconds(self) -> float:
        """Wall-clock time of the training, in all its processes together."""
        return self._log.seconds

    def run(self) -> None:
        """Train.

        Raises:
            Stopped: a signal came; everything is saved.
            NumericalFailure: a number is NaN or infinite; a dump is written.
            UserError: another process may write the run.
        """
        with self._signals, ExitStack() as closing:
            self._closing = closing
            closing.callback(self._parts.agent.learner.close)
            self._open_observers(closing)
            try:
                self._train()
            except failure_dump.CAUSES as error:
                failure = Failure(self.step, first_line(error), self._is_validating)
                argument = controller_argument(self._config)
                raise failure_dump.dump(self._folder, self._states, failure, argument) from error
            self._signals.raise_if_received()
        # Again: the process that wrote the last training state may have been killed before it wrote the weights.
        for name in ("last",) if self._best else ("last", "best"):
            self._save_weights(name)

    def _train(self) -> None:
        total = self._config.total_steps
        try:
            while True:
                self._validate_if_due()
                if self.step >= total:
                    break
                self._episodes.drive_step(total)
                self._save_state_if_due()
                self._signals.raise_if_received()
        except Stopped:
            self._save_state()
            raise
        self._save_state(is_end=True)

    # Observers ----------------------------------------------------------------------------------------------------

    def _open_observers(self, closing: ExitStack) -> None:
        """Open the logs, where they end; what is opened is closed by `closing`, the last first."""
        from asddpg.observers.scalar_events import ScalarEvents  # slow to import: --help does without

        folder, episodes = self._folder, self._episodes
        self._tensorboard = _closed_by(closing, ScalarEvents(folder.tensorboard, self._saved_step))
        outcomes = [row["outcome"] for row in read_rows(folder.metrics)]
        self._log = _closed_by(closing, MetricsLog(folder.metrics, folder.timing, self._tensorboard, self._seconds))
        self._steps = _closed_by(closing, StepLog(folder.step_rows, folder.steps))
        self._bar = _closed_by(closing, ProgressBar(self._config.total_steps, self.step, outcomes))
        recorder = _closed_by(closing, self._make_recorder())
        recorded = OneRobot(recorder, self.step, recorder.go_to)
        episodes.observers += [self._log, self._steps, self._bar, recorded]
        if (live := self._parts.live) is not None:
            live.stops = lambda: self._signals.number != 0
            episodes.observers.append(OneRobot(live, self.step))
        if self._log_states:
            self._log.load_state(self._log_states["metrics"])
            self._steps.go_on(episodes.numbers, episodes.infos)
            if live is not None and episodes.in_progress[0]:
                live.begin_episode(episodes.observations[0], info_of(episodes.infos, 0))

    def _make_recorder(self) -> Recorder:
        """A recorder; of an episode that is resumed it records nothing."""
        record, parts = self._config.record, self._parts
        return Recorder(
            self._folder.episodes,
            parts.robots.envs[0],
            self._provenance,
            Selection(every_nth(record.every), keep=record.keep),
            self._print,
            first_step=self.step,
            first_episode=int(self._episodes.numbers[0]),
            cameras=parts.cameras,
        )

    def _print(self, text: str) -> None:
        (self._bar.print_line if self._bar else print_line)(text)

    # Validation ---------------------------------------------------------------------------------------------------

    def _validate_if_due(self) -> None:
        every = self._config.validation.every
        due = self.step // every if every else 0
        if due > self._validations:
            self._lock.check()
            self._is_validating = True
            self._validate()
            self._is_validating, self._validations = False, due

    def _validate(self) -> None:
        if self._validation_robots is None:
            self._validation_robots = make_validation_robots(self._config)
            self._closing.callback(self._validation_robots.close)
        act = self._parts.agent.act
        result = validate(self._validation_robots, act, self._config, self._signals.raise_if_received)
        estimates = (result.success_rate, result.collision_rate, result.metric)
        success, collision, metric = (cast(float, estimate.value) for estimate in estimates)
        row = {"step": self.step, "success_rate": success, "collision_rate": collision, "metric": metric}
        write_validation(self._folder.validation, self._tensorboard, row)
        rates = f"success {success:.2f}, collision {collision:.2f}"
        self._print(f"step {self.step}: actor alone: {rates} ({result.episodes} validation pairs)")
        self._save_weights("last")
        if self._config.validation.snapshots:
            weights_file.save(self._folder.snapshot(self.step), self._parts.agent.networks, self.step)
        if [success, metric] > self._best:
            self._best = [success, metric]
            self._save_weights("best")

    # Saving -------------------------------------------------------------------------------------------------------

    def _save_weights(self, name: str) -> None:
        weights_file.save(self._folder.checkpoint(name), self._parts.agent.networks, self.step)

    def _save_state_if_due(self) -> None:
        every = self._config.checkpoint_every
        if every and self.step >= (self._saved_step // every + 1) * every:
            self._save_state()

    def _save_state(self, is_end: bool = False) -> None:
        """Write a training state, unless there is one of this step.

        At the end it is written in any case: that of the last step does not have the validation after it.
        """
        best = self._folder.checkpoint("best")
        self._lock.check()
        if self.step == self._saved_step and not is_end:
            return
        self._tensorboard.flush()
        self._steps.flush()
        check_weights(self._parts.agent.learner.finite_weights())
        self._states.write(
            self.step,
            {
                "episodes": self._episodes.state(),
                "logs": {"metrics": self._log.state()},
                "best_weights": np.frombuffer(best.read_bytes(), np.uint8) if self._best else None,
                "validations": self._validations,
                "best": self._best,
                "seconds": self.seconds,
                "files": log_lengths(self._folder.path),
            },
        )
        self._saved_step = self.step
        self._save_weights("last")


def load_episodes(episodes: TrainingEpisodes, state: Mapping[str, Any]) -> None:
    """Restore the episodes of a training state.

    Raises:
        UserError: it is of another agent or environment.
    """
    try:
        episodes.load_state(state["episodes"])
    except (LookupError, RuntimeError, TypeError, ValueError, AttributeError) as error:
        raise UserError(f"the training state of the run does not fit its config.yaml: {error}") from error


def make_validation_robots(config: TrainConfig) -> NavigationVectorEnv:
    """The robots of a validation; with a perfect laser their number changes no figure by more than rounding."""
    return make_robots(config.task, config.reward, min(VALIDATION_ROBOTS, config.validation.episodes))


def validate(
    robots: NavigationVectorEnv,
    act: Callable[[Float32Array], Float32Array],
    config: TrainConfig,
    before_step: Callable[[], None] = lambda: None,
) -> EvaluationResult:
    """Evaluate an actor alone on the stored validation pairs; `act` is as evaluate_side_by_side takes it."""
    task = config.task
    pairs = stored_pairs(task.name, "validation", task.goal_radius, config.validation.episodes, task.robot)
    return evaluate_side_by_side(robots, act, pairs, task.control_timestep, before_step)


def _closed_by(closing: ExitStack, opened: Closable) -> Closable:
    """Close something at the end; an OSError of it must not hide an exception that ended the training."""

    def on_exit(kind: type[BaseException] | None, *_: object) -> None:
        try:
            opened.close()
        except OSError:
            if kind is None:
                raise

    closing.push(on_exit)
    return opened
