"""An exported policy beside the policy itself, on the same observations."""

import time
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import numpy.typing as npt
import onnxruntime

from asddpg.build import make_environment, navigation_env
from asddpg.deployment import load_policy
from asddpg.deployment.onnx_graph import COMMAND, GOAL, PREVIOUS, RANGES, SCANS, VELOCITY
from tasks.gymnasium_api.navigation_env import NavigationEnv

MICROSECONDS = 1e6  # a second
SEED = 0  # of the drives
DECISIONS = 2000  # timed


class OnnxPolicy:
    """An exported policy and the scans that it keeps, as a robot would use it."""

    def __init__(self, file: Path) -> None:
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        self._session = onnxruntime.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])
        self._outputs = [value.name for value in self._session.get_outputs()]
        shapes = {value.name: value.shape[1:] for value in self._session.get_inputs()}
        self._initial = {PREVIOUS: np.zeros((1, *shapes[PREVIOUS]), np.float32)} if PREVIOUS in shapes else {}
        self._kept = self._initial
        self._last: dict[str, npt.NDArray[np.float32]] = {}

    def reset(self) -> None:
        """Forget the scans."""
        self._kept = self._initial

    def act(self, ranges: npt.ArrayLike, velocity: npt.ArrayLike, goal: npt.ArrayLike) -> npt.NDArray[np.float32]:
        """V and ω for a scan by the policy's own beams; SI units."""
        given = {RANGES: ranges, VELOCITY: velocity, GOAL: goal}
        self._last = {name: np.asarray(value, np.float32)[None] for name, value in given.items()} | self._kept
        results = dict(zip(self._outputs, self._session.run(None, self._last), strict=True))
        if self._kept:
            self._kept = {PREVIOUS: results[SCANS]}
        command: npt.NDArray[np.float32] = results[COMMAND][0]
        return command

    def measure(self) -> float:
        """Median time of the last decision, made again and again, seconds."""
        seconds = []
        for _ in range(DECISIONS):
            begun = time.perf_counter()
            self._session.run(None, self._last)
            seconds.append(time.perf_counter() - begun)
        return median(seconds)


def compare(file: Path, run: str, checkpoint: str, observations: int) -> tuple[float, float]:
    """Drive by the policy, and let the file decide beside it.

    Args:
        file: the exported policy.
        run: as of asddpg.deployment.load_policy.
        checkpoint: likewise.
        observations: how many to compare, one or more.

    Returns:
        The greatest difference of a command, m/s or rad/s, and a decision's median time, µs.
    """
    policy, exported, difference = load_policy(run, checkpoint), OnnxPolicy(file), 0.0
    environment = make_environment(policy.config.task, policy.config.reward)
    inner, angles = navigation_env(environment), policy.config.task.laser.ring.angles()
    is_over = True
    for step in range(observations):
        if is_over:
            environment.reset(seed=SEED if step == 0 else None)
            policy.reset()
            exported.reset()
        ranges, velocity, goal = _read(inner)
        command = policy.act(ranges, angles, *velocity, goal)
        difference = max(difference, float(np.abs(exported.act(ranges, velocity, goal) - command).max()))
        _, _, terminated, truncated, _ = environment.step(np.array(command, np.float32))
        is_over = terminated or truncated
    environment.close()
    return difference, MICROSECONDS * exported.measure()


def _read(environment: NavigationEnv) -> tuple[Any, tuple[float, float], tuple[float, float]]:
    """Ranges of all rays with infinity where there is no return, v and ω, and the goal."""
    physics, readings = environment.physics, environment.task.readings
    ranges = physics.ranges()
    velocity = (readings.velocity.linear, readings.velocity.angular)
    return np.where(ranges < physics.max_range, ranges, np.inf), velocity, readings.goal_in_robot_frame
