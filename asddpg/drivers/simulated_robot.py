"""The robot of an environment, as planning drivers see it."""

import numpy as np

from asddpg.build import action_bounds
from asddpg.drivers.room_map import draw_room_map
from asddpg.episodes.protocols import Observation
from asddpg.planning.occupancy_grid import OccupancyGrid
from asddpg.planning.robot import Reading, RobotShape
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.laser import laser_position
from tasks.room_geometry.footprints import Footprint

_NO_RETURN = 0.5  # in the observation, of a beam that reads the maximum range


class SimulatedRobot:
    """Its true pose, its goal, and the newest scan, with whatever noise the laser has.

    Attributes:
        shape: body and laser.
    """

    def __init__(self, environment: NavigationEnv, room_map: OccupancyGrid | None) -> None:
        self._task = environment.task
        self.shape, self._map = read_shape(environment), room_map

    @property
    def map(self) -> OccupancyGrid | None:
        """Of the room; None for a driver that is to know nothing."""
        return self._map

    @property
    def goal(self) -> tuple[float, float]:
        """The environment's: x and y, metres, map frame."""
        return self._task.readings.goal

    def read(self, observation: Observation) -> Reading:
        """The robot at the instant of the newest observation."""
        readings = self._task.readings
        scan = observation[: len(self.shape.beams)].astype(np.float64)
        ranges = np.where(scan < _NO_RETURN, (scan + 0.5) * self.shape.max_range, np.inf)
        return Reading(readings.pose, readings.velocity, readings.goal, ranges)


class RobotThatKnowsRoom(SimulatedRobot):
    """Its map is that of the present room."""

    def __init__(self, environment: NavigationEnv) -> None:
        super().__init__(environment, None)
        self._environment = environment
        self._mapped: str | None = None  # the room of the map, where it changes

    @property
    def map(self) -> OccupancyGrid | None:
        """Of the present room; None before the first."""
        room = self._task.room
        if room != "" and (self._map is None or self._mapped != room):
            self._map, self._mapped = draw_room_map(self._environment.obstacles), room
        return self._map


def read_shape(environment: NavigationEnv) -> RobotShape:
    """Body, laser and limits of an environment's robot."""
    model = environment.physics.model.ptr
    footprint = Footprint.from_model(model)
    low, high = ((float(v), float(omega)) for v, omega in action_bounds(environment))
    return RobotShape(
        footprint=np.array(footprint.outline),
        inscribed_radius=footprint.inscribed_radius,
        laser=laser_position(model)[:2],
        beams=environment.task.config.laser.angles(),
        max_range=environment.physics.max_range,
        control_timestep=environment.task.config.control_timestep,
        low=low,
        high=high,
    )


def with_room_map(environment: NavigationEnv) -> SimulatedRobot:
    """A robot that knows its room."""
    return RobotThatKnowsRoom(environment)
