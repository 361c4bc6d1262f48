"""Keys to commands: what a keyboard asks of the robot, without a screen."""

from tasks.constants import MAX_ANGULAR_VELOCITY, MAX_LINEAR_VELOCITY
from tasks.physics import Velocity

# GLFW's codes, which MuJoCo's viewer hands on. The passive viewer uses neither the arrows nor space; it has nearly all
# letters for itself (what is drawn) and the digits (groups of geoms), and Backspace for a reset of its own.
RIGHT, LEFT, DOWN, UP, SPACE, BACKSPACE = 262, 263, 264, 265, 32, 259

LINEAR_STEP = 0.1  # m/s a press
ANGULAR_STEP = MAX_ANGULAR_VELOCITY / 6  # rad/s a press

# Key → what a press of it adds to the forward speed and to the turn rate.
_STEPS = {UP: (LINEAR_STEP, 0.0), DOWN: (-LINEAR_STEP, 0.0), LEFT: (0.0, ANGULAR_STEP), RIGHT: (0.0, -ANGULAR_STEP)}

HELP = (
    ("up, down", f"faster ahead, slower and back, {LINEAR_STEP:g} m/s a press"),
    ("left, right", f"turn further to that side, {ANGULAR_STEP:.2g} rad/s a press"),
    ("space", "stop"),
    ("Backspace", "back to the start"),
    ("Esc", "MuJoCo's free camera; [ and ] its others; F1 its own help"),
)


class Teleop:
    """The command that the keys pressed so far add up to.

    Attributes:
        command: forward speed in ±MAX_LINEAR_VELOCITY (m/s) and turn rate in ±MAX_ANGULAR_VELOCITY (rad/s).
    """

    def __init__(self) -> None:
        self.command = Velocity(0.0, 0.0)

    def press(self, key: int) -> None:
        """Take a key, GLFW's code; one that means nothing here changes nothing."""
        if key in (SPACE, BACKSPACE):
            self.command = Velocity(0.0, 0.0)
            return
        more_linear, more_angular = _STEPS.get(key, (0.0, 0.0))
        linear, angular = self.command.linear + more_linear, self.command.angular + more_angular
        self.command = Velocity(
            _clipped(linear, MAX_LINEAR_VELOCITY, LINEAR_STEP), _clipped(angular, MAX_ANGULAR_VELOCITY, ANGULAR_STEP)
        )


def _clipped(value: float, limit: float, step: float) -> float:
    """Within ±limit, and on a whole number of steps, so that as many presses back end at rest."""
    return max(-limit, min(limit, step * round(value / step)))
