"""move_base of ROS as a driver: a global plan, DWA along it, and recoveries where DWA finds no way."""

from collections.abc import Mapping

import numpy as np

from asddpg.episodes.protocols import Decision, Driver, Observation, Step
from asddpg.planning.dwa import DWA, DWAOptions
from asddpg.planning.navigator import Navigator, NavigatorOptions
from asddpg.planning.robot import Reading, Robot

STUCK_AFTER = 0.4  # s without a command until the robot, at rest by then, may go nearer to obstacles
PATIENCE = 1.0  # s without a command from DWA until a recovery begins
RECOVERY_TURN = 2.0 * np.pi  # rad
RECOVERY_RATE = 1.0  # rad/s


class MoveBase:
    """Plans and drives with a map and the laser; makes no use of the flat observation but through its robot.

    Recoveries come in turn, as move_base has them: forget what the laser saw; turn once around.
    """

    def __init__(self, robot: Robot, navigator: NavigatorOptions | None = None, dwa: DWAOptions | None = None) -> None:
        self._robot, self._navigator_options, self._dwa_options = robot, navigator or NavigatorOptions(), dwa
        self._low, self._high = np.array(robot.shape.low), np.array(robot.shape.high)
        self.begin_episode()

    def begin_episode(self) -> None:
        """Forget the last episode's map and plan."""
        self.navigator: Navigator | None = None
        self._dwa = DWA(self._robot.shape, self._dwa_options)
        self._idle = 0.0  # s without a command
        self._recoveries = 0
        self._turn_left = 0.0  # rad

    def decide(self, observation: Observation) -> Decision:
        """Plan, and choose the next command."""
        reading = self._robot.read(observation)
        if self.navigator is None:
            self.navigator = Navigator(self._robot, self._navigator_options, reading)
        self.navigator.update(reading)
        command = (
            self._turn(reading, self.navigator) if self._turn_left > 0.0 else self._follow(reading, self.navigator)
        )
        return Decision(np.clip(command, self._low, self._high).astype(np.float32), Driver.PLANNER)

    def learn(self, step: Step) -> Mapping[str, float]:
        """A planner learns nothing."""
        return {}

    def _follow(self, reading: Reading, navigator: Navigator) -> tuple[float, float]:
        is_stuck, path = self._idle >= STUCK_AFTER, navigator.path
        command = None if path is None else self._dwa.choose(reading, path, navigator.costmap, is_stuck)
        if command is not None:
            self._idle = 0.0
            return command
        self._idle += self._robot.shape.control_timestep
        if self._idle >= PATIENCE:
            self._recover(navigator)
        return 0.0, 0.0

    def _recover(self, navigator: Navigator) -> None:
        self._idle, self._recoveries = 0.0, self._recoveries + 1
        if self._recoveries % 2:
            navigator.clear()
        else:
            self._turn_left = RECOVERY_TURN

    def _turn(self, reading: Reading, navigator: Navigator) -> tuple[float, float]:
        rate = min(RECOVERY_RATE, float(self._high[1]))
        step = rate * self._robot.shape.control_timestep
        self._turn_left -= step
        if not self._dwa.can_turn(reading.pose, step, navigator.costmap):
            self._turn_left = 0.0
            return 0.0, 0.0
        return 0.0, rate
