"""Makes the drivers that agent= names: controller, random actions, planners, and a user's own."""

from collections.abc import Callable, Mapping
from typing import Any

import gymnasium
import numpy as np

from asddpg.build import action_bounds, controller_for, navigation_env
from asddpg.config import DrivingConfig, PlannerConfig
from asddpg.episodes.drivers import controller_alone, random_actor
from asddpg.episodes.protocols import Agent, Decision, Driver, Observation, Step
from asddpg.episodes.random_streams import stream
from asddpg.errors import UserError, import_factory
from asddpg.planning.move_base import MoveBase
from asddpg.planning.navigator import NavigatorOptions
from asddpg.planning.robot import Robot
from asddpg.planning.waypoints import WaypointDriver
from tasks.gymnasium_api.navigation_env import NavigationEnv

MakeRobot = Callable[[NavigationEnv], Robot]

PLANNERS = ("move_base", "waypoints")
PRESET_SPEED = ("controller", "random")  # drive with the least speed that a task's preset has for policies


def make_baseline(config: DrivingConfig, environment: gymnasium.Env, seed: int, make_robot: MakeRobot) -> Agent:
    """The driver of agent=.

    Args:
        config: of the program.
        environment: which it drives.
        seed: of random actions.
        make_robot: what a planner or a driver of one's own reads.

    Raises:
        UserError: there is no such driver, or it cannot be made.
    """
    inner = navigation_env(environment)
    if config.agent == "random":
        return random_actor(*action_bounds(environment), stream(seed, "exploration"))
    if config.agent == "move_base":
        return MoveBase(make_robot(inner), _navigator_options(config.planner))
    if config.agent in ("controller", "waypoints"):
        controller = controller_alone(controller_for(environment, config.controller))
        return (
            controller
            if config.agent == "controller"
            else lead_by_waypoints(controller, make_robot(inner), config.planner)
        )
    return _make_own(str(config.agent), inner, make_robot(inner))


def lead_by_waypoints(driver: Agent, robot: Robot, planner: PlannerConfig) -> Agent:
    """A driver whose goals are the waypoints of a global plan."""
    return WaypointDriver(robot, driver, planner.look_ahead, _navigator_options(planner))


def _navigator_options(planner: PlannerConfig) -> NavigatorOptions:
    return NavigatorOptions(uses_map=planner.map == "known")


def _make_own(name: str, environment: NavigationEnv, robot: Robot) -> Agent:
    factory = import_factory(name)
    if factory is None:
        raise UserError(f"there is no driver {name!r}: package.module:Factory must name a class or a function")
    try:
        driver = factory(robot)
    except TypeError as error:
        raise UserError(f"the driver {name!r} cannot be made: {error}; it is made as Factory(robot)") from error
    if not callable(getattr(driver, "act", None)):
        raise UserError(f"the driver {name!r} has no method act(observation)")
    return OwnDriver(driver, name, environment)


class OwnDriver:
    """A driver of a user's: any object with act(observation) and, if it has a memory, begin_episode()."""

    def __init__(self, driver: Any, name: str, environment: NavigationEnv) -> None:
        self._driver, self._name = driver, name
        self._low, self._high = action_bounds(environment)

    @property
    def identity(self) -> str:
        """What a driver says that it is by an attribute of that name, such as the digest of its weights; or nothing."""
        return str(getattr(self._driver, "identity", ""))

    def begin_episode(self) -> None:
        """Reset the driver's memory, if it has one."""
        begin = getattr(self._driver, "begin_episode", None)
        if begin is not None:
            begin()

    def decide(self, observation: Observation) -> Decision:
        """What the driver does, cut at the bounds of the action space.

        Raises:
            UserError: it does not give as many finite numbers as an action has.
        """
        action = np.asarray(self._driver.act(observation), dtype=np.float32)
        if action.shape != self._low.shape or not np.isfinite(action).all():
            raise UserError(f"the driver {self._name!r} must give v and ω, two finite numbers, not {action}")
        return Decision(np.clip(action, self._low, self._high), Driver.OWN)

    def learn(self, step: Step) -> Mapping[str, float]:
        """Nothing."""
        return {}
