"""What a driver may know of its robot beyond the flat observation."""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

from asddpg.episodes.protocols import Observation
from asddpg.planning.occupancy_grid import FloatArray, OccupancyGrid


class Reading(NamedTuple):
    """The robot at the instant of an observation.

    Attributes:
        pose: x, y (m) and yaw (rad) of the base, map frame.
        velocity: forward speed (m/s) and turn rate (rad/s).
        goal: x and y, metres, map frame.
        ranges: of the newest scan, from right to left, metres, (num_beams,); inf for a beam without a return.
    """

    pose: tuple[float, float, float]
    velocity: tuple[float, float]
    goal: tuple[float, float]
    ranges: FloatArray


@dataclass(frozen=True, eq=False)
class RobotShape:
    """The robot's body and laser, in the base's frame.

    Attributes:
        footprint: corners of its convex outline, counter-clockwise, metres, (n, 2).
        inscribed_radius: of the largest circle about the base's axis inside it, metres.
        laser: x and y of the laser, metres.
        beams: directions of the beams, rad, (num_beams,).
        max_range: of the laser, metres.
        control_timestep: seconds from one decision to the next.
        low: smallest v (m/s) and ω (rad/s).
        high: largest.
    """

    footprint: FloatArray
    inscribed_radius: float
    laser: tuple[float, float]
    beams: FloatArray
    max_range: float
    control_timestep: float
    low: tuple[float, float]
    high: tuple[float, float]


class Robot(Protocol):
    """A robot in a room: a driver's own is made as `Factory(robot)`, and reads it in each of its decisions.

    Attributes:
        shape: body and laser.
    """

    shape: RobotShape

    @property
    def map(self) -> OccupancyGrid | None:
        """What is known of the room beforehand; None for nothing."""

    def read(self, observation: Observation) -> Reading:
        """The robot at the instant of the newest observation."""
