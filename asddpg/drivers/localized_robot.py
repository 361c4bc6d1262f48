"""A robot that knows its pose only by its wheels, its laser and a map."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from asddpg.drivers.simulated_robot import SimulatedRobot
from asddpg.episodes.protocols import Observation
from asddpg.planning.amcl import AMCL, AMCLOptions
from asddpg.planning.likelihood_field import LaserOptions
from asddpg.planning.occupancy_grid import OccupancyGrid
from asddpg.planning.odometry import MotionNoise, OdometryErrors, WheelOdometry
from asddpg.planning.poses import wrap_angle
from asddpg.planning.robot import Reading
from tasks.gymnasium_api.navigation_env import NavigationEnv

# Between two updates the pose is that of the odometry, with its drift: they come twice as often as the node's. Its sum
# of cubes is nearly equal for poses 5 cm from one another: the estimate would run after the odometry. With its noise
# of motion an obstacle that the map lacks pulls the estimate to the wall behind it.
PRECISE = AMCLOptions(
    update_distance=0.1,
    update_angle=math.pi / 12,
    noise=MotionNoise(0.05, 0.05, 0.05, 0.05),
    laser=LaserOptions(sigma_hit=0.1, beam_power=0.3),
)
# From no idea where, in a room of like corners: a broad likelihood that keeps many places, and random particles.
GLOBAL = replace(PRECISE, noise=MotionNoise(), laser=LaserOptions(), alpha_slow=0.001, alpha_fast=0.1)
START_SPREAD = (0.1, 0.1, 0.1)  # m, m, rad; of a start that is known about


@dataclass(frozen=True)
class LocalizationOptions:
    """How well the robot can know its pose.

    Attributes:
        errors: of its odometry.
        ticks: of an encoder in a turn of its wheel.
        amcl: constants of the filter.
    """

    errors: OdometryErrors = field(default_factory=OdometryErrors)
    ticks: int = 2000
    amcl: AMCLOptions = PRECISE


class LocalizedRobot:
    """Its readings are those of an environment's robot, with the pose and the speeds that it estimates itself.

    Attributes:
        shape: body and laser.
        map: which it localises itself on, and plans by.
        amcl: the filter.
        reading: the newest.
    """

    reading: Reading

    def __init__(
        self,
        environment: NavigationEnv,
        room_map: OccupancyGrid,
        rng: np.random.Generator,
        options: LocalizationOptions | None = None,
    ) -> None:
        self._inner, self._physics = SimulatedRobot(environment, room_map), environment.physics
        self.shape, self.map = self._inner.shape, room_map
        chosen = options or LocalizationOptions()
        drive = self._physics.drive
        self._odometry = WheelOdometry(drive.radius, drive.track, chosen.ticks, chosen.errors)
        self.amcl = AMCL(room_map, self.shape.max_range, rng, (*self.shape.laser, 0.0), chosen.amcl)
        self._time = -1.0

    def begin(self, observation: Observation, pose: tuple[float, float, float] | None) -> Reading:
        """Begin at an environment's first observation, about at a pose (m, rad; map frame), or anywhere."""
        if pose is None:
            self.amcl.start_anywhere()
        else:
            self.amcl.start_at(pose, START_SPREAD)
        self._odometry.reset((0.0, 0.0, 0.0), self._physics.wheel_angles())
        self._time = -1.0
        return self.read(observation)

    def read(self, observation: Observation) -> Reading:
        """The robot as it knows itself at the newest observation; until the next nothing changes but the goal."""
        if self._physics.time() != self._time:
            before, seconds = self._odometry.pose, self._physics.time() - self._time
            odometry = self._odometry.update(self._physics.wheel_angles())
            found = self._inner.read(observation)
            self.amcl.update(odometry, found.ranges, self.shape.beams)
            is_first, self._time = self._time < 0.0, self._physics.time()
            velocity = (0.0, 0.0) if is_first else _velocity(before, odometry, seconds)
            x, y, yaw = self.amcl.pose()
            self.reading = found._replace(pose=(float(x), float(y), float(yaw)), velocity=velocity)
        elif self._inner.goal != self.reading.goal:
            self.reading = self.reading._replace(goal=self._inner.goal)
        return self.reading


def _velocity(before: np.ndarray, after: np.ndarray, seconds: float) -> tuple[float, float]:
    """Mean v (m/s) and ω (rad/s) between two poses of the odometry."""
    dx, dy = after[0] - before[0], after[1] - before[1]
    turn = float(wrap_angle(after[2] - before[2]))
    middle = before[2] + turn / 2.0
    return float(np.cos(middle) * dx + np.sin(middle) * dy) / seconds, turn / seconds
