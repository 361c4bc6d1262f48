"""The diagnosis of a run: metrics of its snapshots and of its training."""

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
from tools.diagnosis.returns import FloatArray, Tail, tail_bounds
from tools.diagnosis.rollouts import Rollout, critic_values, drive
from tools.diagnosis.training_metrics import TrainingMetrics


@dataclass(frozen=True)
class Snapshot:
    """Metrics of the weights after `step` training steps; None where there is no switch.

    Attributes:
        actor: the actor alone.
        switched: the switched policy: actor or controller, as the switch chooses, without noise.
        q_actor: Q^A(x, π(x)) against the return of the actor alone.
        q_policy: Q(x, policy) against the return of the actor alone.
        q_switched: Q(x, σ) of the σ chosen against the return of the switched policy.
        q_controller: Q(x, controller) against the return of the controller alone.
    """

    step: int
    actor: DriveMetrics
    switched: DriveMetrics | None
    q_actor: QCalibration
    q_policy: QCalibration | None
    q_switched: QCalibration | None
    q_controller: QCalibration | None


@dataclass(frozen=True)
class Diagnosis:
    """All metrics of a run; goal_radius in metres."""

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


class Examiner:
    """Drives the start-goal pairs, snapshot by snapshot."""

    def __init__(
        self, config: TrainConfig, environment: gymnasium.Env, agent: AsDDPG, pairs: Sequence[StartGoalPair]
    ) -> None:
        """Drive the controller alone once, if there is one: it does not depend on the snapshot."""
        self._config, self._environment, self._agent, self._pairs = config, environment, agent, pairs
        self.tail = tail_bounds(config)
        self.by_controller = self._drive(controller_alone(agent.controller)) if agent.controller else []
        self.by_actor: list[Rollout] = []  # of the latest snapshot

    def _drive(self, driver: Any) -> list[Rollout]:
        return drive(self._environment, driver, self._pairs, self._config.agent)

    def examine_snapshot(self, step: int) -> Snapshot:
        """Metrics of the weights that the agent has now."""
        self.by_actor = self._drive(actor_alone(self._agent))
        by_switched = self._drive(with_switch(self._agent)) if self.by_controller else []
        alone = critic_values(self._agent, self.by_actor)
        q_switched, q_controller = self._examine_switch(by_switched)
        return Snapshot(
            step=step,
            actor=drive_metrics(self.by_actor, self._config.task),
            switched=drive_metrics(by_switched, self._config.task) if by_switched else None,
            q_actor=self._calibrate(alone.actor, self.by_actor),
            q_policy=None if alone.policy is None else self._calibrate(alone.policy, self.by_actor),
            q_switched=q_switched,
            q_controller=q_controller,
        )

    def _examine_switch(self, by_switched: Sequence[Rollout]) -> tuple[QCalibration | None, QCalibration | None]:
        """Q of the driver chosen on the switched policy's states, and Q(controller) on the controller's."""
        if not by_switched:
            return None, None
        switched, alone = critic_values(self._agent, by_switched), critic_values(self._agent, self.by_controller)
        assert switched.policy is not None
        assert switched.controller is not None
        assert alone.controller is not None
        chosen = np.maximum(switched.policy, switched.controller)
        return self._calibrate(chosen, by_switched), self._calibrate(alone.controller, self.by_controller)

    def _calibrate(self, q: FloatArray, rollouts: Sequence[Rollout]) -> QCalibration:
        return q_calibration(q, rollouts, self._config.agent.gamma, self.tail)

    def diagnosis(self, run: str, snapshots: list[Snapshot], training: TrainingMetrics) -> Diagnosis:
        """The metrics of snapshots, training and controller together."""
        config, by_controller = self._config, self.by_controller
        return Diagnosis(
            run=run,
            task=config.task.name,
            agent=config.agent.name,
            episodes=len(self._pairs),
            gamma=config.agent.gamma,
            goal_radius=config.task.goal_radius,
            tail=self.tail,
            controller=drive_metrics(by_controller, config.task) if by_controller else None,
            snapshots=snapshots,
            training=training,
        )


def to_json(value: Any) -> Any:
    """Metrics as dictionaries and lists, estimates as in evaluation.json: value and 95 % interval.

    NaN and infinity, which a diverged critic gives, become null.
    """
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Estimate):
        return {"value": value.value, "ci95": [value.low, value.high]}
    if isinstance(value, Tail):
        return value._asdict()
    if dataclasses.is_dataclass(value):
        return {field.name: to_json(getattr(value, field.name)) for field in dataclasses.fields(value)}
    return [to_json(part) for part in value] if isinstance(value, list) else value
