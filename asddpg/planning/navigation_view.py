"""What a robot knows of the room and intends in it, for recordings and viewers."""

from typing import NamedTuple, Protocol, runtime_checkable

from asddpg.planning.navigator import Navigator
from asddpg.planning.occupancy_grid import FloatArray, OccupancyGrid


class NavigationView(NamedTuple):
    """At one instant; arrays are not changed later, but replaced. None where there is no such thing.

    Attributes:
        map: what is known of the room.
        path: of the global planner, (n, 2), metres, map frame.
        particles: of the localisation, (n, 3), x, y (m) and yaw (rad), map frame.
        pose: that the robot believes to have, x, y (m) and yaw (rad), map frame.
    """

    map: OccupancyGrid | None = None
    path: FloatArray | None = None
    particles: FloatArray | None = None
    pose: tuple[float, float, float] | None = None


@runtime_checkable
class PlanningDriver(Protocol):
    """A driver with a global planner."""

    navigator: Navigator | None  # None before the first decision of an episode


def view_plan(driver: object) -> NavigationView:
    """Map and path of a driver, if it plans."""
    navigator = driver.navigator if isinstance(driver, PlanningDriver) else None
    return NavigationView() if navigator is None else NavigationView(navigator.map, navigator.path)
