"""Keys to velocity commands; needs no screen."""

from tasks.constants import MAX_ANGULAR_VELOCITY, MAX_LINEAR_VELOCITY
from tasks.physics import Velocity

# GLFW's codes, as MuJoCo's viewer reports them. The passive viewer leaves the arrows and space free; it uses nearly all
# letters (drawing options), the digits (groups of geoms), and Backspace for a reset of its own.
RIGHT, LEFT, DOWN, UP, SPACE, BACKSPACE = 262, 263, 264, 265, 32, 259

LINEAR_STEP = 0.1  # m/s a press
ANGULAR_STEP = MAX_ANGULAR_VELOCITY / 6  # rad/s a press

# Key → change of the forward speed and of the turn rate by one press.
_STEPS = {UP: (LINEAR_STEP, 0.0), DOWN: (-LINEAR_STEP, 0.0), LEFT: (0.0, ANGULAR_STEP), RIGHT: (0.0, -ANGULAR_STEP)}

HELP = (
    ("up, down", f"faster ahead, slower and back, {LINEAR_STEP:g} m/s a press"),
    ("left, right", f"turn further to that side, {ANGULAR_STEP:.2g} rad/s a press"),
    ("space", "stop"),
    ("Backspace", "back to the start"),
    ("Esc", "MuJoCo's free camera; [ and ] its others; F1 its own help"),
)


def next_command(command: Velocity, key: int) -> Velocity:
    """The command after a key, GLFW's code, within ±MAX_LINEAR_VELOCITY and ±MAX_ANGULAR_VELOCITY.

    Keys without a meaning change nothing.
    """
    if key in (SPACE, BACKSPACE):
        return Velocity(0.0, 0.0)
    linear_step, angular_step = _STEPS.get(key, (0.0, 0.0))
    return Velocity(
        _clip(command.linear + linear_step, MAX_LINEAR_VELOCITY, LINEAR_STEP),
        _clip(command.angular + angular_step, MAX_ANGULAR_VELOCITY, ANGULAR_STEP),
    )


def _clip(value: float, limit: float, step: float) -> float:
    """Clip to ±limit, rounded to whole steps, so that as many presses back end at rest."""
    return max(-limit, min(limit, step * round(value / step)))
