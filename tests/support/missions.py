"""Missions without their program: a room, a robot whose belief a test may set, and steps for a log."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asddpg.command_line import driver_config
from asddpg.config import MissionConfig
from asddpg.drivers.driver_setup import DriverSetup, Setting, set_up_driver
from asddpg.drivers.localized_robot import LocalizedRobot
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Decision, Driver, Episode, Step
from asddpg.missions.environment import Mission, MissionEnvironment
from asddpg.missions.log import MissionLog
from asddpg.missions.setting import MissionSetting, draw_mission
from tasks.gymnasium_api.navigation_env import NavigationEnv

Pose = tuple[float, float, float]
NOTHING = np.zeros(6, dtype=np.float32)  # an observation that a log does not look at
STOP = Decision(np.zeros(2, dtype=np.float32), Driver.PLANNER)


@dataclass(frozen=True)
class Stage:
    """What the program puts together before its first mission."""

    config: MissionConfig
    setting: MissionSetting
    setup: DriverSetup
    environment: NavigationEnv
    robot: LocalizedRobot
    missions: MissionEnvironment

    def drive(self, number: int) -> MissionLog:
        """Drive the mission of a number."""
        log = MissionLog(draw_mission(self.config, self.environment, number))
        run_episode(self.missions, self.setup.drivers[self.setup.name], (log,), {"mission": log.mission})
        return log


def make_stage(*arguments: str) -> Stage:
    """By arguments of the program; move_base in nav_empty without others."""
    config = driver_config(MissionConfig, ["agent=move_base", "task=nav_empty", *arguments])
    setting = MissionSetting(config)
    setup = set_up_driver(config, "mission", config.seed, Setting(setting.prepare_task, setting.make_robot))
    environment = setup.environment.unwrapped
    assert isinstance(environment, NavigationEnv)
    robot = setting.make_robot(environment)
    missions = MissionEnvironment(environment, robot, config.within, config.patience)
    return Stage(config, setting, setup, environment, robot, missions)


class Belief:
    """Replaces the estimate of a stage's robot by one that the test sets."""

    def __init__(self, stage: Stage, pose: Pose) -> None:
        self.pose = pose
        stage.robot.amcl.pose = lambda: np.array(self.pose)  # type: ignore[method-assign]


def log_of(
    places: Sequence[tuple[Pose, Pose]], targets: Sequence[tuple[float, float]], infos: Sequence[dict[str, Any]] = ()
) -> MissionLog:
    """A log of true poses and estimates, at the beginning and after each step; `infos` has more of each step."""
    mission = Mission(places[0][0], tuple(targets), seed=0)
    log, reached = MissionLog(mission), 0
    log.begin_episode(NOTHING, {"pose": places[0][0], "estimate": places[0][1]})
    for index, (pose, estimate) in enumerate(places[1:]):
        goal = targets[min(reached, len(targets) - 1)]
        info: dict[str, Any] = {"pose": pose, "estimate": estimate, "touched": (), "target": reached, "goal": goal}
        info |= infos[index] if index < len(infos) else {}
        info["distance"] = float(np.hypot(*np.subtract(info["goal"], pose[:2])))
        reached = info["target"]
        log.step(Step(NOTHING, STOP, 0.0, NOTHING, False, False, info), {})
    log.end_episode(Episode(outcome="reached" if reached == len(targets) else "timeout"))
    return log
