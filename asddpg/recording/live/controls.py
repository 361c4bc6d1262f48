"""What a viewer may change: Foxglove's parameters and goals, and their valid values.

Requests come in threads of the server; the driving thread reads them between two steps. Each is one attribute or a
queue, written and read whole, and `wake_event` is set after it.
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
        """Valid names of `driver`."""

    def set_goal(self, x: float, y: float) -> None:
        """Move the goal, metres, world frame; UserError or TaskError where it would not be free."""


class GoalRequest(NamedTuple):
    """A goal that a viewer requests: metres, in a frame by name."""

    frame: str
    x: float
    y: float


class LiveControls:
    """The parameters, and the goal requests that wait for the driving thread."""

    def __init__(self, speed: float, steering: Steering | None) -> None:
        """Begin at a speed, in simulated seconds a second; without steering neither driver nor goal can be set."""
        self.speed, self.paused, self.step_once = speed, False, False
        self.goal = (0.0, 0.0)  # m, world frame; written by the driving thread
        self.goals: SimpleQueue[GoalRequest] = SimpleQueue()
        self.wake_event = threading.Event()
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
            UserError: there is no such parameter, or the value is invalid.
        """
        if name not in self._setters:
            raise UserError(f"there is no parameter {name!r}; there are {', '.join(self.values())}")
        self._setters[name](value)
        self.wake_event.set()

    def request_goal(self, request: GoalRequest) -> None:
        """Queue a goal; UserError without steering."""
        if self._steering is None:
            raise UserError(f"a goal {_OF_PLAY}")
        self.goals.put(request)
        self.wake_event.set()

    def take_single_step(self) -> bool:
        """Whether a single step was requested since the last call."""
        if not self.step_once:
            return False  # without a write, which would lose a request that comes at this moment
        self.step_once = False
        return True

    # Setters ------------------------------------------------------------------------------------------------------

    def _set_paused(self, value: Any) -> None:
        self.paused = _boolean(PAUSED, value)

    def _set_step_once(self, value: Any) -> None:
        if _boolean(STEP_ONCE, value):
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
        self.request_goal(GoalRequest("", *(_metres(number) for number in value)))


def parse_goal(message: Any) -> GoalRequest:
    """The goal in a message of Foxglove's: a point, or a pose, with a frame in itself or in its header.

    Raises:
        UserError: it is neither.
    """
    try:
        place = message["point"] if "point" in message else message["pose"]["position"]
        frame = message.get("frame_id", message.get("header", {}).get("frame_id", ""))
        return GoalRequest(str(frame).strip("/"), _metres(place["x"]), _metres(place["y"]))
    except (KeyError, TypeError, AttributeError) as error:
        wanted = '{"point": {"x": 1, "y": 2}} or {"pose": {"position": {"x": 1, "y": 2}}}, metres'
        raise UserError(f"a goal is a message such as {wanted}") from error


def _metres(number: Any) -> float:
    if isinstance(number, bool) or not isinstance(number, int | float) or not abs(number) < math.inf:
        raise UserError(f"a goal's x and y are numbers, metres, not {number!r}")
    return float(number)


def _boolean(name: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise UserError(f"{name} must be true or false, not {value!r}")
    return value
