"""Keys to velocity commands; needs no screen."""

from tasks.constants import MAX_ANGULAR_VELOCITY, MAX_LINEAR_VELOCITY
from tasks.physics import Velocity

# GLFW's codes, as MuJoCo's viewer reports them. The passive viewer leaves the arrows and space free; it uses nearly all
# letters (drawing options), the digits (groups of geoms), and Backspace for a reset of its own.
RIGHT, LEFT, DOWN, UP, SPACE, BACKSPACE = 262, 263, 264, 265, 32, 259

LIMITS = (MAX_LINEAR_VELOCITY, MAX_ANGULAR_VELOCITY)  # m/s and rad/s, of the Pioneer
LINEAR_PRESSES, ANGULAR_PRESSES = 5, 6  # from rest to the limit

# Key → presses that it counts for the forward speed and for the turn rate.
_PRESSES = {UP: (1, 0), DOWN: (-1, 0), LEFT: (0, 1), RIGHT: (0, -1)}


def help_lines(limits: tuple[float, float]) -> tuple[tuple[str, str], ...]:
    """The keys and what they do, for a robot's largest v (m/s) and ω (rad/s)."""
    return (
        ("up, down", f"faster ahead, slower and back, {limits[0] / LINEAR_PRESSES:.2g} m/s a press"),
        ("left, right", f"turn further to that side, {limits[1] / ANGULAR_PRESSES:.2g} rad/s a press"),
        ("space", "stop"),
        ("Backspace", "back to the start"),
        ("Esc", "MuJoCo's free camera; [ and ] its others; F1 its own help"),
    )


def next_command(command: Velocity, key: int, limits: tuple[float, float] = LIMITS) -> Velocity:
    """The command after a key, GLFW's code, within ± the limits of v (m/s) and ω (rad/s).

    Keys without a meaning change nothing.
    """
    if key in (SPACE, BACKSPACE):
        return Velocity(0.0, 0.0)
    linear_step, angular_step = limits[0] / LINEAR_PRESSES, limits[1] / ANGULAR_PRESSES
    ahead, left = _PRESSES.get(key, (0, 0))
    return Velocity(
        _clip(command.linear + ahead * linear_step, limits[0], linear_step),
        _clip(command.angular + left * angular_step, limits[1], angular_step),
    )


def _clip(value: float, limit: float, step: float) -> float:
    """Clip to ±limit, rounded to whole steps, so that as many presses back end at rest."""
    return max(-limit, min(limit, step * round(value / step)))
