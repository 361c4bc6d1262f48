"""A trained policy in SI units, for a ROS node or another simulator."""

import numpy as np
import numpy.typing as npt

from asddpg.config import TrainConfig
from asddpg.deployment.scan_resampling import ScanResampler
from asddpg.errors import UserError
from asddpg.runs import weights_file
from asddpg.runs.loading import open_trained
from asddpg.runs.pretrained import Policy
from tasks.gymnasium_api.flat_observation import ScanStack
from tasks.navigation import clip_goal


class SIPolicy:
    """Drives by scans of any laser that sees where the policy's own did.

    Attributes:
        config: of the training; `config.task.laser` is the policy's laser.
        control_timestep: seconds from one act() to the next.
    """

    def __init__(self, policy: Policy) -> None:
        """Wrap a policy."""
        self.config: TrainConfig = policy.config
        task, laser = self.config.task, self.config.task.laser
        self.control_timestep = task.control_timestep
        self._policy, self._resampler = policy, ScanResampler(laser)
        self._stack, self._begun = ScanStack(task.num_scans, laser.num_beams, laser.max_range), False

    def reset(self) -> None:
        """Forget the scans: the next one is the first, as after a stop or a new goal far away."""
        self._begun = False

    def act(
        self,
        ranges: npt.ArrayLike,
        angles: npt.ArrayLike,
        velocity: float,
        turn_rate: float,
        goal: tuple[float, float],
    ) -> tuple[float, float]:
        """The command for the next control step: v (m/s) and ω (rad/s), to the left positive.

        Call it once every `control_timestep`: it keeps the last scans.

        Args:
            ranges: of the newest scan, metres, (n,); +inf is no return, −inf too near, NaN, 0 and less invalid.
            angles: of its beams from straight ahead, to the left positive, rad, (n,).
            velocity: forward speed, m/s.
            turn_rate: rad/s, to the left positive.
            goal: metres ahead of and to the left of the midpoint between the driven wheels.

        Raises:
            UserError: the scan lacks beams that the policy needs, none is valid, or another number is not finite.
        """
        motion, place = np.array([velocity, turn_rate], dtype=np.float64), np.array(goal, dtype=np.float64)
        if place.shape != (2,) or not (np.isfinite(motion).all() and np.isfinite(place).all()):
            found = f"not v {velocity}, ω {turn_rate}, goal {goal}"
            raise UserError(f"velocity, turn rate and goal (x, y) must be finite numbers, {found}")
        seen = np.array(clip_goal((float(place[0]), float(place[1])), self.config.task.goal_range))
        observation = {"ranges": self._resampler.resample(ranges, angles), "velocity": motion, "goal": seen}
        flat = self._stack.push(observation) if self._begun else self._stack.reset(observation)
        self._begun = True
        linear, angular = self._policy.act(flat).tolist()
        return linear, angular


def load_policy(run: str, checkpoint: str = "last") -> SIPolicy:
    """A policy by `pretrained:<name>`, or by the folder of a run.

    Args:
        run: what it names.
        checkpoint: of a run's folder, last or best.

    Raises:
        UserError: there is no such policy, or its files are damaged.
    """
    opened = open_trained(run, checkpoint, controller=None)
    networks, step, observation_size = weights_file.read(opened.weights)
    task = opened.config.task
    if observation_size != task.num_scans * task.laser.num_beams + 4:
        raise UserError(f"{opened.weights} is for other scans than its config.yaml describes")
    return SIPolicy(Policy(networks, opened.config, step, observation_size))
