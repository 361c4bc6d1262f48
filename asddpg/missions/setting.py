"""What a mission's robot knows, and where it is sent."""

import itertools
import re
from collections.abc import Sequence

import mujoco
import numpy as np

from asddpg.config import MissionConfig, TaskConfig
from asddpg.drivers.localized_robot import LocalizationOptions, LocalizedRobot
from asddpg.drivers.room_map import draw_room_map
from asddpg.errors import UserError
from asddpg.missions.environment import Mission, Point
from asddpg.planning.odometry import OdometryErrors
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.registry import ANYWHERE
from tasks.room_geometry.obstacles import Obstacles, obstacle_names

DRAWN_TARGETS, DRAWN_OBSTACLES = 5, 5
APART = 2.0  # m, at least, from a drawn target to the next
ENDLESS = 10**6  # steps: the environment below a mission ends none
_OBSTACLES, _PARTICLES, _MISSIONS = range(3)  # streams of a seed


class MissionSetting:
    """What a mission changes of the task, and the robot that it is driven with; the same for all missions of a program.

    Attributes:
        unmapped: names of the obstacles that the map lacks.
        known: obstacles on the map.
        robot: localises itself on that map.
    """

    unmapped: tuple[str, ...]
    known: Obstacles
    robot: LocalizedRobot

    def __init__(self, config: MissionConfig) -> None:
        self._config = config
        self._environment: NavigationEnv | None = None  # of the robot

    def prepare_task(self, task: TaskConfig) -> None:
        """Leave it to the mission where an episode ends, and give the laser its noise.

        Raises:
            UserError: the task has another room in each episode.
        """
        if task.name == ANYWHERE:
            raise UserError(f"a mission needs one room, not {ANYWHERE}: task=nav_office, a file, or rooms:4")
        task.goal_radius, task.time_limit_steps, task.laser.noise = 0.0, ENDLESS, self._config.noise

    def make_robot(self, environment: NavigationEnv) -> LocalizedRobot:
        """The robot of an environment, made once: driver and mission share its estimate.

        Raises:
            TaskError: the room has no obstacle of a name that the map is to lack.
        """
        if environment is not self._environment:
            config, model = self._config, environment.physics.model.ptr
            unmapped = _draw_unmapped(config.seed, model) if config.unmapped is None else config.unmapped
            self.unmapped, self.known = tuple(unmapped), Obstacles.from_model(model, unmapped)
            options = LocalizationOptions(OdometryErrors(1.0 + config.drift, 1.0 + config.drift))
            rng = np.random.default_rng([config.seed, _PARTICLES])
            self.robot = LocalizedRobot(environment, draw_room_map(self.known), rng, options)
            self._environment = environment
        return self.robot


def draw_mission(config: MissionConfig, environment: NavigationEnv, number: int) -> Mission:
    """The mission of a number: start and targets as given, or drawn by the task's own rule.

    Raises:
        TaskError: a given place is not free.
    """
    rng = np.random.default_rng([config.seed, _MISSIONS, number])
    start, _ = environment.task.rule.draw(rng, np.zeros((0, 2)))
    x, y, yaw = config.start or start
    targets = _targets(config.targets, environment, rng, (x, y))
    return Mission((x, y, yaw), targets, int(rng.integers(2**31)))


def _targets(
    given: Sequence[float], environment: NavigationEnv, rng: np.random.Generator, start: Point
) -> tuple[Point, ...]:
    if given:
        targets = tuple(zip(given[::2], given[1::2], strict=True))
        for place in targets:
            environment.task.check_place("target", *place)
        return targets
    places = [start]
    while len(places) <= DRAWN_TARGETS:
        _, place = environment.task.rule.draw(rng, np.zeros((0, 2)))
        if np.hypot(*np.subtract(place, places[-1])) >= APART:
            places.append(place)
    return tuple(places[1:])


def _draw_unmapped(seed: int, model: mujoco.MjModel) -> list[str]:
    """Five obstacles that are no walls and no fence, or as many as there are."""
    names = [name for name in obstacle_names(model) if not re.search(r"(^|_)(wall|fence)", name)]
    parts = {name: itertools.accumulate(name.split("_"), "{}_{}".format) for name in names}
    whole = [name for name in names if not any(part in parts for part in parts[name] if part != name)]
    rng = np.random.default_rng([seed, _OBSTACLES])
    drawn: list[str] = rng.permutation(whole)[:DRAWN_OBSTACLES].tolist()
    return drawn
