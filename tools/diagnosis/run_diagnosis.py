"""A run's diagnosis: all figures of its snapshots and of its training."""

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np

from asddpg.algorithm.agent import AsDDPG
from asddpg.config import TrainConfig
from asddpg.episodes.drivers import actor_alone, controller_alone, with_switch
from asddpg.episodes.evaluation import StartGoalPair
from asddpg.episodes.intervals import Estimate
from tools.diagnosis.drive_metrics import DriveMetrics, QCalibration, drive_metrics, q_calibration
from tools.diagnosis.returns import FloatArray, Tail, tail_of
from tools.diagnosis.rollouts import Rollout, drive, values_of
from tools.diagnosis.training_metrics import TrainingMetrics


@dataclass(frozen=True)
class Snapshot:
    """What the networks did and knew after so many steps of training; None where there is no switch.

    Attributes:
        actor: the actor alone.
        pair: actor and controller by the switch, without noise.
        q_actor: Q^A(x, π(x)) against the return of the actor alone.
        q_policy: Q(x, policy) against the return of the actor alone.
        q_pair: Q(x, σ) of the σ chosen against the return of the pair.
        q_controller: Q(x, controller) against the return of the controller alone.
    """

    step: int
    actor: DriveMetrics
    pair: DriveMetrics | None
    q_actor: QCalibration
    q_policy: QCalibration | None
    q_pair: QCalibration | None
    q_controller: QCalibration | None


@dataclass(frozen=True)
class Diagnosis:
    """All figures of a run; goal_radius in metres."""

    run: str
    task: str
    agent: str
    episodes: int
    gamma: float
    goal_radius: float
    tail: Tail
    controller: DriveMetrics | None
    snapshots: list[Snapshot]
    training: TrainingMetrics


class Examination:
    """Drives the pairs, snapshot by snapshot."""

    def __init__(
        self, config: TrainConfig, environment: gymnasium.Env, agent: AsDDPG, pairs: Sequence[StartGoalPair]
    ) -> None:
        """Drive the controller alone, where there is one: it does not depend on the snapshot."""
        self._config, self._environment, self._agent, self._pairs = config, environment, agent, pairs
        self.tail = tail_of(config)
        self.by_controller = self._drive(controller_alone(agent.controller)) if agent.controller else []
        self.by_actor: list[Rollout] = []  # of the latest snapshot

    def _drive(self, driver: Any) -> list[Rollout]:
        return drive(self._environment, driver, self._pairs, self._config.agent)

    def of_controller(self) -> DriveMetrics | None:
        """Figures of the controller alone."""
        return drive_metrics(self.by_controller, self._config.task) if self.by_controller else None

    def of_snapshot(self, step: int) -> Snapshot:
        """Figures of the weights that the agent now has."""
        self.by_actor = self._drive(actor_alone(self._agent))
        by_pair = self._drive(with_switch(self._agent)) if self.by_controller else []
        alone = values_of(self._agent, self.by_actor)
        q_pair, q_controller = self._of_switch(by_pair)
        return Snapshot(
            step=step,
            actor=drive_metrics(self.by_actor, self._config.task),
            pair=drive_metrics(by_pair, self._config.task) if by_pair else None,
            q_actor=self._judged(alone.of_actor, self.by_actor),
            q_policy=None if alone.of_policy is None else self._judged(alone.of_policy, self.by_actor),
            q_pair=q_pair,
            q_controller=q_controller,
        )

    def _of_switch(self, by_pair: Sequence[Rollout]) -> tuple[QCalibration | None, QCalibration | None]:
        """Q of what the switch chose on the pair's states, and Q(controller) on the controller's."""
        if not by_pair:
            return None, None
        of_pair, of_controller = values_of(self._agent, by_pair), values_of(self._agent, self.by_controller)
        assert of_pair.of_policy is not None
        assert of_pair.of_controller is not None
        assert of_controller.of_controller is not None
        chosen = np.maximum(of_pair.of_policy, of_pair.of_controller)
        return self._judged(chosen, by_pair), self._judged(of_controller.of_controller, self.by_controller)

    def _judged(self, q: FloatArray, rollouts: Sequence[Rollout]) -> QCalibration:
        return q_calibration(q, rollouts, self._config.agent.gamma, self.tail)


def diagnosis_of(
    run: str, config: TrainConfig, examination: Examination, snapshots: list[Snapshot], training: TrainingMetrics
) -> Diagnosis:
    """Snapshots and training in one."""
    return Diagnosis(
        run=run,
        task=config.task.name,
        agent=config.agent.name,
        episodes=snapshots[0].actor.episodes,
        gamma=config.agent.gamma,
        goal_radius=config.task.goal_radius,
        tail=examination.tail,
        controller=examination.of_controller(),
        snapshots=snapshots,
        training=training,
    )


def as_json(figure: Any) -> Any:
    """Figures as dictionaries and lists, estimates as in evaluation.json: value and 95 % interval.

    JSON knows no nan and no infinity, which a critic that diverged gives: they become null.
    """
    if isinstance(figure, float) and not math.isfinite(figure):
        return None
    if isinstance(figure, Estimate):
        return {"value": figure.value, "ci95": [figure.low, figure.high]}
    if isinstance(figure, Tail):
        return figure._asdict()
    if dataclasses.is_dataclass(figure):
        return {field.name: as_json(getattr(figure, field.name)) for field in dataclasses.fields(figure)}
    return [as_json(part) for part in figure] if isinstance(figure, list) else figure
