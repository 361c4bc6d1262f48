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
from asddpg.episodes.drivers import FixedDriver, actor_alone, controller_alone
from asddpg.episodes.evaluation import StartGoalPair
from asddpg.episodes.intervals import Estimate
from tasks.physics import FloatArray
from tools.diagnosis.drive_metrics import DriveMetrics, QCalibration, drive_metrics, q_calibration
from tools.diagnosis.returns import Tail, tail_bounds
from tools.diagnosis.rollouts import Rollout, critic_values, drive
from tools.diagnosis.training_metrics import TrainingMetrics


@dataclass(frozen=True)
class Snapshot:
    """Metrics of the weights after `step` training steps; None where there is no switch."""

    step: int
    actor: DriveMetrics  # the actor alone
    q_actor: QCalibration  # Q^A(x, π(x)) against the return of the actor alone
    switched: DriveMetrics | None = None  # actor or controller, as the switch chooses, without noise
    q_policy: QCalibration | None = None  # Q(x, policy) against the return of the actor alone
    q_switched: QCalibration | None = None  # Q(x, σ) of the σ chosen against the return of the switched policy
    q_controller: QCalibration | None = None  # Q(x, controller) against the return of the controller alone


@dataclass(frozen=True)
class Diagnosis:
    """All metrics of a run, as in diagnosis.json; goal_radius in metres."""

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
    """Drives the start-goal pairs, snapshot by snapshot.

    Attributes:
        diagnosis: the metrics so far.
        by_actor: the actor's episodes with the latest snapshot.
    """

    def __init__(
        self,
        run: str,
        config: TrainConfig,
        agent: AsDDPG,
        environment: gymnasium.Env,
        pairs: Sequence[StartGoalPair],
        training: TrainingMetrics,
    ) -> None:
        """Drive the controller alone once, if there is one: it does not depend on the snapshot."""
        self._config, self._environment, self._agent, self._pairs = config, environment, agent, pairs
        self._by_controller = self._drive(controller_alone(agent.controller)) if agent.controller else []
        self.by_actor: list[Rollout] = []
        self.diagnosis = Diagnosis(
            run=run,
            task=config.task.name,
            agent=config.agent.name,
            episodes=len(pairs),
            gamma=config.agent.gamma,
            goal_radius=config.task.goal_radius,
            tail=tail_bounds(config),
            controller=drive_metrics(self._by_controller, config.task) if self._by_controller else None,
            snapshots=[],
            training=training,
        )

    def _drive(self, driver: FixedDriver) -> list[Rollout]:
        return drive(self._environment, driver, self._pairs, self._config.agent)

    def examine_snapshot(self, step: int) -> Snapshot:
        """Add the metrics of the weights that the agent has now, those after `step` training steps."""
        self.diagnosis.snapshots.append(self._examine(step))
        return self.diagnosis.snapshots[-1]

    def _examine(self, step: int) -> Snapshot:
        agent, task = self._agent, self._config.task
        self.by_actor = self._drive(actor_alone(agent))
        actor, q = drive_metrics(self.by_actor, task), critic_values(agent, self.by_actor)
        q_actor = self._calibrate(q["actor"], self.by_actor)
        if not self._by_controller:
            return Snapshot(step, actor, q_actor)
        by_switched = self._drive(FixedDriver(agent.decide_greedily))
        q_switched = critic_values(agent, by_switched)
        q_chosen = np.maximum(q_switched["policy"], q_switched["controller"])
        q_alone = critic_values(agent, self._by_controller)["controller"]
        return Snapshot(
            step,
            actor,
            q_actor,
            switched=drive_metrics(by_switched, task),
            q_policy=self._calibrate(q["policy"], self.by_actor),
            q_switched=self._calibrate(q_chosen, by_switched),
            q_controller=self._calibrate(q_alone, self._by_controller),
        )

    def _calibrate(self, q: FloatArray, rollouts: Sequence[Rollout]) -> QCalibration:
        return q_calibration(q, rollouts, self._config.agent.gamma, self.diagnosis.tail)


def to_json(value: Any) -> Any:
    """Metrics as dictionaries and lists, estimates as in evaluation.json: value and 95 % interval.

    NaN and infinity, which a diverged critic gives, become null.
    """
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Estimate):
        return {"value": value.value, "ci95": [value.low, value.high]}
    if dataclasses.is_dataclass(value):
        return {field.name: to_json(getattr(value, field.name)) for field in dataclasses.fields(value)}
    return [to_json(part) for part in value] if isinstance(value, list) else value
