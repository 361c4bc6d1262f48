"""A training: episodes until the steps are used up, validations and checkpoints between them."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, SupportsFloat

import gymnasium
import numpy as np

from asddpg.algorithm.agent import AsDDPG
from asddpg.build import make_environment, navigation_env
from asddpg.config import TrainConfig
from asddpg.episodes.drivers import actor_alone
from asddpg.episodes.evaluation import EvaluationResult, evaluate
from asddpg.episodes.protocols import Callback, Observer, Step
from asddpg.observers.finite_check import FiniteCheck
from asddpg.observers.metrics_log import MetricsLog, read_rows
from asddpg.observers.progress import ProgressBar
from asddpg.observers.step_log import StepLog
from asddpg.observers.validation_log import write_validation
from asddpg.recording.live.live_view import LiveView
from asddpg.recording.pictures.cameras import Cameras
from asddpg.recording.recorder import Provenance, Recorder, Selection, every_nth
from asddpg.runs import append_only_logs, failure_dump, weights_file
from asddpg.runs.checkpoints import TrainingStates
from asddpg.runs.lock import RunLock
from asddpg.runs.resumable import ResumableEpisodes
from asddpg.runs.run_folder import RunFolder
from asddpg.runs.safe_loading import controller_argument
from asddpg.runs.signals import StopBetweenSteps, Stopped, StopSignals
from tasks.evaluation_pairs import stored_pairs


@dataclass(frozen=True)
class Parts:
    """What a training is put together from, all of it made before anything is written."""

    config: TrainConfig
    environment: gymnasium.Env
    agent: AsDDPG
    cameras: Cameras | None = None
    live: LiveView | None = None


class Training:
    """From its beginning, or from where a checkpoint has it, to its end."""

    def __init__(
        self,
        parts: Parts,
        folder: RunFolder,
        lock: RunLock,
        provenance: Provenance,
        state: Mapping[str, Any] | None = None,
    ) -> None:
        """Begin a training, or go on from a checkpoint; nothing is written yet.

        Args:
            parts: what it is put together from.
            folder: the run's.
            lock: of the folder.
            provenance: for recordings.
            state: of the checkpoint, as TrainingStates gave it.

        Raises:
            UserError: the checkpoint is of another agent.
        """
        self._parts, self._config, self._folder = parts, parts.config, folder
        self._lock, self._provenance = lock, provenance
        # A second one: validating must not disturb the episode in progress or the stream of its goals.
        self._validation_environment = make_environment(self._config.task, self._config.reward)
        self._states = TrainingStates(self._folder.training_states)
        self._episodes = ResumableEpisodes(parts.environment, parts.agent, self._config.seed, self._say)
        self._validations, self._seconds = 0, 0.0
        self._best: list[float] = []  # success rate and metric, compared in this order
        self._kept = 0  # training step of the newest checkpoint
        self._bar: ProgressBar | None = None
        self._is_validating = False
        if state is not None:
            self._episodes.load_state(state["episodes"])
            self._validations, self._seconds = state["validations"], state["seconds"]
            self._best, self._kept = state["best"], state["step"]

    @property
    def step(self) -> int:
        """Training steps made so far."""
        return self._episodes.step

    @property
    def seconds(self) -> float:
        """What it has taken, in all processes together."""
        return self._log.seconds

    def run(self) -> None:
        """Train.

        Raises:
            Stopped: a signal came; everything is kept.
            Breakdown: a number is none; a dump is kept.
            UserError: another process may write the run.
        """
        with StopSignals() as signals, ExitStack() as closing:
            observers = self._observers(closing, signals)
            try:
                self._train_and_keep(observers, signals)
            except failure_dump.CAUSES as error:
                trouble = failure_dump.Trouble(self.step, failure_dump.first_line(error), self._is_validating)
                raise failure_dump.stopped(
                    self._folder, self._states, trouble, controller_argument(self._config)
                ) from error
            if signals.number:
                raise Stopped(signals.number)
        # Again: the process that wrote the last checkpoint may have been killed before it came to the weights.
        for name in ("last",) if self._best else ("last", "best"):
            weights_file.save(self._folder.checkpoint(name), self._parts.agent, self._episodes.step)

    def _train_and_keep(self, observers: Sequence[Observer], signals: StopSignals) -> None:
        try:
            self._train(observers, signals)
        except Stopped:
            self._keep()
            raise
        self._keep(is_end=True)

    def _train(self, observers: Sequence[Observer], signals: StopSignals) -> None:
        total = self._config.total_steps
        while True:
            self._validate_if_due(signals)
            if self._episodes.steps >= total:
                return
            self._lock.check()
            self._episodes.drive_episode(observers, max_steps=total - self._episodes.steps)

    # Who watches --------------------------------------------------------------------------------------------------

    def _observers(self, closing: ExitStack, signals: StopSignals) -> list[Observer]:
        """Open the logs, where they end; what is opened is closed by `closing`, the last first."""
        from asddpg.observers.scalar_events import ScalarEvents  # slow to import: not for those who ask for help

        folder, parts, done = self._folder, self._parts, self._episodes
        self._tensorboard = ScalarEvents(folder.tensorboard, self._kept)
        _close(self._tensorboard.close, closing)
        outcomes = [row["outcome"] for row in read_rows(folder.metrics)]
        self._log = MetricsLog(folder.metrics, folder.timing, self._tensorboard, self._seconds)
        _close(self._log.close, closing)
        steps = StepLog(folder.step_rows, folder.steps, done.episodes)
        _close(steps.close, closing)
        self._bar = ProgressBar(self._config.total_steps, done.steps, outcomes)
        _close(self._bar.close, closing)
        recorder = self._recorder()
        _close(recorder.close, closing)
        observers: list[Observer] = [FiniteCheck(), self._log, steps, self._bar, recorder]
        if parts.live is not None:
            parts.live.stops = lambda: signals.number != 0
            observers.append(parts.live)
        return [*observers, _Checkpoints(self), StopBetweenSteps(signals)]

    def _recorder(self) -> Recorder:
        wanted, parts = self._config.record, self._parts
        return Recorder(
            self._folder.episodes,
            navigation_env(parts.environment),
            self._provenance,
            Selection(every_nth(wanted.every), keep=wanted.keep),
            self._say,
            first_step=self._episodes.steps,
            first_episode=self._episodes.episodes,
            cameras=parts.cameras,
        )

    def _say(self, text: str) -> None:
        (self._bar.say if self._bar else print)(text)

    # Validating ---------------------------------------------------------------------------------------------------

    def _validate_if_due(self, signals: StopSignals) -> None:
        every = self._config.validation.every
        due = self._episodes.steps // every if every else 0
        if due > self._validations:
            self._lock.check()
            self._is_validating = True
            self._validate(StopBetweenSteps(signals))
            self._is_validating, self._validations = False, due

    def _validate(self, stopping: Observer) -> None:
        config, agent, step = self._config, self._parts.agent, self._episodes.steps
        result = validate(self._validation_environment, agent, config, [stopping])
        reach, crash, metric = (result.success_rate.value, result.collision_rate.value, result.metric.value)
        assert reach is not None
        assert crash is not None
        assert metric is not None
        row = {"step": step, "success_rate": reach, "collision_rate": crash, "metric": metric}
        write_validation(self._folder.validation, self._tensorboard, row)
        self._say(
            f"step {step}: actor alone reaches {reach:.2f}, crashes {crash:.2f} ({result.episodes} validation pairs)"
        )
        weights_file.save(self._folder.checkpoint("last"), agent, step)
        if config.validation.snapshots:
            weights_file.save(self._folder.snapshot(step), agent, step)
        if [reach, metric] > self._best:
            self._best = [reach, metric]
            weights_file.save(self._folder.checkpoint("best"), agent, step)

    # Keeping ------------------------------------------------------------------------------------------------------

    def keep_if_due(self) -> None:
        """Write a checkpoint, if it is time for one."""
        every = self._config.checkpoint_every
        if every and self._episodes.step >= (self._kept // every + 1) * every:
            self._keep()

    def _keep(self, is_end: bool = False) -> None:
        """Write a checkpoint, unless there is one of this step, or of a later one to which is being driven again.

        At the end it is written in any case: that of the last step does not have the validation after it.
        """
        step, agent, best = self._episodes.step, self._parts.agent, self._folder.checkpoint("best")
        self._lock.check()
        if step <= self._kept and not is_end:
            return
        self._tensorboard.flush()
        self._episodes.check_weights()
        self._states.write(
            step,
            {
                "episodes": self._episodes.state(),
                "best_weights": np.frombuffer(best.read_bytes(), np.uint8) if self._best else None,
                "validations": self._validations,
                "best": self._best,
                "seconds": self.seconds,
                "files": append_only_logs.lengths(self._folder.path),
            },
        )
        self._kept = step
        weights_file.save(self._folder.checkpoint("last"), agent, step)


def _close(close: Callable[[], None], closing: ExitStack) -> None:
    """Have something closed at the end; where it cannot be, that must not hide why the end has come."""

    def leave(kind: type[BaseException] | None, *_: object) -> None:
        try:
            close()
        except OSError:
            if kind is None:
                raise

    closing.push(leave)


def validate(
    environment: gymnasium.Env, agent: AsDDPG, config: TrainConfig, observers: Sequence[Observer] = ()
) -> EvaluationResult:
    """Figures of the actor alone on the stored validation pairs."""
    pairs = stored_pairs(config.task.name, "validation", config.task.goal_radius)[: config.validation.episodes]
    return evaluate(environment, actor_alone(agent), pairs, config.task.control_timestep, observers)


class _Checkpoints(Callback):
    """Watches, and has a checkpoint written after the step at which it is due."""

    def __init__(self, training: Training) -> None:
        self._training = training

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Write it, if it is due."""
        self._training.keep_if_due()
