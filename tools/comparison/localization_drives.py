"""A drive from goal to goal, and how far AMCL's estimate is from the true pose meanwhile."""

from dataclasses import dataclass

import numpy as np

from asddpg.build import make_environment, navigation_env
from asddpg.command_line import train_config
from asddpg.drivers.localized_robot import GLOBAL, PRECISE, LocalizationOptions, LocalizedRobot
from asddpg.drivers.room_map import draw_room_map
from asddpg.drivers.simulated_robot import with_room_map
from asddpg.episodes.protocols import Observation
from asddpg.planning.move_base import MoveBase
from asddpg.planning.occupancy_grid import FloatArray
from asddpg.planning.odometry import OdometryErrors
from asddpg.planning.poses import wrap_angle
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.room_geometry.obstacles import Obstacles

NEXT_GOAL_WITHIN = 0.6  # m, of the true pose; farther than the goal's radius, so that no episode ends


@dataclass(frozen=True)
class DriveOptions:
    """How a drive is made.

    Attributes:
        task: the room.
        seconds: simulated, if nothing ends it.
        unmapped: obstacles that AMCL's map lacks.
        noise: scale of the laser's noise.
        drift: by how much odometry takes lengths and turns for too long, as a share.
        is_start_known: whether AMCL begins near the true pose, else anywhere.
    """

    task: str
    seconds: float
    unmapped: tuple[str, ...]
    noise: float
    drift: float
    is_start_known: bool


@dataclass(frozen=True)
class Drive:
    """Errors of the estimate at every control step: metres and rad, (steps,)."""

    seed: int
    control_timestep: float
    distances: FloatArray
    angles: FloatArray

    def is_found(self, distance: float, seconds: float) -> bool:
        """Whether the estimate stays within a distance (m) of the true pose for the last seconds."""
        return bool((self.distances[-round(seconds / self.control_timestep) :] <= distance).all())


def drive(options: DriveOptions, seed: int) -> Drive:
    """Drive with start, goals, noise and particles of a seed."""
    environment = _make_environment(options)
    planner = MoveBase(with_room_map(environment))
    localized = _make_localized(environment, options, seed)
    observation, info = environment.reset(seed=seed)
    planner.begin_episode()
    goals = np.random.default_rng(seed)
    localized.begin(observation, info["pose"] if options.is_start_known else None)
    errors = []
    for _ in range(round(options.seconds / environment.task.config.control_timestep)):
        observation, _, terminated, truncated, info = environment.step(
            planner.decide(observation).action.astype(np.float64)
        )
        if terminated or truncated:
            break
        reading = localized.read(observation)
        x, y, yaw = np.subtract(reading.pose, info["pose"])
        errors.append((np.hypot(x, y), abs(wrap_angle(yaw))))
        if info["distance"] < NEXT_GOAL_WITHIN:
            observation = _draw_goal(environment, goals)
    environment.close()
    distances, angles = np.array(errors).T
    return Drive(seed, environment.task.config.control_timestep, distances, angles)


def _make_environment(options: DriveOptions) -> NavigationEnv:
    config = train_config(
        [
            f"task={options.task}",
            "task.min_linear_velocity=0",
            f"task.laser.noise={options.noise}",
            f"task.time_limit_steps={10**6}",
        ]
    )
    return navigation_env(make_environment(config.task, config.reward))


def _make_localized(environment: NavigationEnv, options: DriveOptions, seed: int) -> LocalizedRobot:
    known = Obstacles.from_model(environment.physics.model.ptr, options.unmapped)
    factor = 1.0 + options.drift
    amcl = PRECISE if options.is_start_known else GLOBAL
    localization = LocalizationOptions(OdometryErrors(factor, factor), amcl=amcl)
    return LocalizedRobot(environment, draw_room_map(known), np.random.default_rng(seed), localization)


def _draw_goal(environment: NavigationEnv, rng: np.random.Generator) -> Observation:
    """Another goal of the task's own rule, for the episode in progress; the observation with it."""
    while True:
        _, (x, y) = environment.task.rule.draw(rng, np.zeros((0, 2)))
        pose = environment.task.readings.pose
        if np.hypot(x - pose.x, y - pose.y) > 2.0 * NEXT_GOAL_WITHIN:
            return environment.set_goal(x, y)
