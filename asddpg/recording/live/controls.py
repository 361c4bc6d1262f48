"""What a viewer may change while it watches: Foxglove's parameters and goals, and which of their values are right.

A viewer's wishes come in threads of the server's; whoever drives reads them between two steps. Each is one attribute or
a queue, written and read whole, and `woken` is set after it.
"""

import math
import threading
from collections.abc import Callable, Mapping, Sequence
from queue import SimpleQueue
from typing import Any, NamedTuple, Protocol

from asddpg.errors import UserError

DRIVER, GOAL, PAUSED, SPEED, STEP_ONCE = "/driver", "/goal", "/paused", "/speed", "/step_once"
_OF_PLAY = "belongs to python -m asddpg.play: a training chooses driver and goals itself"


class Steering(Protocol):
    """What may be changed of an episode in progress."""

    driver: str

    @property
    def drivers(self) -> Sequence[str]:
        """Names that `driver` may be."""

    def set_goal(self, x: float, y: float) -> None:
        """Another goal, metres, world frame; UserError or TaskError where none can lie."""


class GoalWish(NamedTuple):
    """Where a viewer wants the goal: metres, in a frame by name."""

    frame: str
    x: float
    y: float


class LiveControls:
    """Wishes that were granted, and those that wait for the driving thread."""

    def __init__(self, speed: float, steering: Steering | None) -> None:
        """Begin at a speed, in simulated seconds a second; without steering there is nothing to steer."""
        self.speed, self.paused, self.step_once = speed, False, False
        self.goal = (0.0, 0.0)  # m, world frame; kept up by the driving thread
        self.goals: SimpleQueue[GoalWish] = SimpleQueue()
        self.woken = threading.Event()
        self._steering = steering
        self._setters: Mapping[str, Callable[[Any], None]] = {
            PAUSED: self._set_paused,
            STEP_ONCE: self._set_step_once,
            SPEED: self._set_speed,
            DRIVER: self._set_driver,
            GOAL: self._set_goal,
        }

    def values(self) -> dict[str, Any]:
        """The parameters by name."""
        values: dict[str, Any] = {PAUSED: self.paused, STEP_ONCE: False, SPEED: float(self.speed)}
        if self._steering is not None:
            values |= {DRIVER: self._steering.driver, GOAL: [float(number) for number in self.goal]}
        return values

    def set(self, name: str, value: Any) -> None:
        """Set a parameter.

        Raises:
            UserError: there is none of that name, or the value is none for it.
        """
        if name not in self._setters:
            raise UserError(f"there is no parameter {name!r}; there are {', '.join(self.values())}")
        self._setters[name](value)
        self.woken.set()

    def wish_goal(self, wish: GoalWish) -> None:
        """Ask for a goal; UserError where nobody steers."""
        if self._steering is None:
            raise UserError(f"a goal {_OF_PLAY}")
        self.goals.put(wish)
        self.woken.set()

    def take_step(self) -> bool:
        """Whether a single step was asked for; it is then no more."""
        if not self.step_once:
            return False  # and nothing is written: it might be asked for at this very moment
        self.step_once = False
        return True

    # Setters ------------------------------------------------------------------------------------------------------

    def _set_paused(self, value: Any) -> None:
        self.paused = _truth(PAUSED, value)

    def _set_step_once(self, value: Any) -> None:
        if _truth(STEP_ONCE, value):
            self.step_once = self.paused = True  # in this order: paused alone would hold a step that is allowed

    def _set_speed(self, value: Any) -> None:
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < math.inf:
            raise UserError(f"{SPEED} must be a number, 0 or more, not {value!r}; 0 goes as fast as it can")
        self.speed = float(value)

    def _set_driver(self, value: Any) -> None:
        if self._steering is None:
            raise UserError(f"{DRIVER} {_OF_PLAY}")
        if value not in self._steering.drivers:
            raise UserError(f"there is no driver {value!r}; there are {', '.join(self._steering.drivers)}")
        self._steering.driver = value

    def _set_goal(self, value: Any) -> None:
        if not isinstance(value, list | tuple) or len(value) != 2:
            raise UserError(f"{GOAL} must be two numbers, x and y in metres, not {value!r}")
        self.wish_goal(GoalWish("", *(_metres(number) for number in value)))


def goal_in(message: Any) -> GoalWish:
    """The goal of a message of Foxglove's: a point, or a pose, with a frame in itself or in its header.

    Raises:
        UserError: it is none.
    """
    try:
        place = message["point"] if "point" in message else message["pose"]["position"]
        frame = message.get("frame_id", message.get("header", {}).get("frame_id", ""))
        return GoalWish(str(frame).strip("/"), _metres(place["x"]), _metres(place["y"]))
    except (KeyError, TypeError, AttributeError) as error:
        wanted = '{"point": {"x": 1, "y": 2}} or {"pose": {"position": {"x": 1, "y": 2}}}, metres'
        raise UserError(f"a goal is a message such as {wanted}") from error


def _metres(number: Any) -> float:
    if isinstance(number, bool) or not isinstance(number, int | float) or not abs(number) < math.inf:
        raise UserError(f"a goal's x and y are numbers, metres, not {number!r}")
    return float(number)


def _truth(name: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise UserError(f"{name} must be true or false, not {value!r}")
    return value
