"""Properties of the robot, from the compiled model: `python -m tools.robot_figures`."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks.options import argument, option
from tasks.physics import FloatArray
from tasks.scene.loading import open_scene
from tools.robot.robot_model import RobotModel
from tools.robot.scene_argument import ROBOT, SCENE, scene_file


@dataclass(frozen=True)
class RobotFiguresArguments:
    """The scene with the robot, and the form of its figures."""

    scene: str = argument("A task, pioneer for the robot alone, or a path to an .xml scene with it.", ROBOT, SCENE)
    json: bool = option(False, "Whether they are printed as JSON, for machines.")


class Quantity(NamedTuple):
    """A value with its unit and, where its name is not enough, a note."""

    value: float | list[float] | list[str] | None
    unit: str
    note: str = ""


Sections = dict[str, dict[str, Quantity]]


def measure_robot(robot: RobotModel) -> Sections:
    """All quantities by section and name."""
    return {
        "mass": _mass(robot),
        "drive": _drive(robot),
        "performance of the drive": _abilities(robot),
        "footprint": _footprint(robot),
        **{f"rangefinders {name}": _ring(robot, name) for name in robot.rangefinder_rings()},
        "sensors": {kind: Quantity(names, "") for kind, names in robot.sensors().items()},
        "cameras": {
            name: Quantity(
                [*place.tolist(), float(np.rad2deg(fovy))], "m, m, m, deg", "x, y, z, vertical field of view"
            )
            for name, (place, fovy) in robot.cameras().items()
        },
    }


def _mass(robot: RobotModel) -> dict[str, Quantity]:
    inertia = robot.inertia()
    return {
        "total": Quantity(robot.mass(), "kg"),
        **{f"body {name}": Quantity(mass, "kg") for name, mass in robot.masses().items()},
        "centre of mass": _vector(robot.centre_of_mass(), "m", "x, y, z in the frame of base"),
        "inertia": _vector(np.diag(inertia), "kg·m²", "xx, yy, zz about the centre of mass, joints held"),
        "inertia, products": _vector(inertia[[0, 0, 1], [1, 2, 2]], "kg·m²", "xy, xz, yz"),
    }


def _drive(robot: RobotModel) -> dict[str, Quantity]:
    return {
        "wheel radius": Quantity(robot.wheel_radius(), "m"),
        "track": Quantity(robot.track(), "m", "between the wheels' contact points"),
        "wheel speed limit": _limit(robot.wheel_speed_limit(), "rad/s"),
        "wheel torque limit": _limit(robot.wheel_torque_limit(), "N·m"),
        "velocity servo": Quantity(robot.servo_gain(), "N·m·s/rad"),
        "wheel inertia": Quantity(robot.spin_inertia(), "kg·m²", "about the axle, armature included"),
        "friction on the floor": Quantity(robot.friction(), ""),
    }


def _abilities(robot: RobotModel) -> dict[str, Quantity]:
    radius, speed = robot.wheel_radius(), robot.wheel_speed_limit()
    rolling_mass = robot.mass() + 2 * robot.spin_inertia() / radius**2
    gravity = abs(float(robot.model.opt.gravity[2]))
    share = robot.load_on_wheels()
    return {
        "speed": _limit(speed * radius, "m/s", "both wheels at their limit"),
        "turn rate": _limit(2 * speed * radius / robot.track(), "rad/s", "wheels at their limit, against each other"),
        "acceleration by torque": _limit(
            2 * robot.wheel_torque_limit() / radius / rolling_mass, "m/s²", "from rest, with the wheels' spin"
        ),
        "acceleration by grip": Quantity(robot.friction() * gravity, "m/s²", "mu·g, all weight on the wheels"),
        "weight on the wheels": Quantity(100 * share, "%", "at rest; the caster carries the rest"),
        "acceleration by that grip": Quantity(robot.friction() * gravity * share, "m/s²", "mu·g times that share"),
    }


def _footprint(robot: RobotModel) -> dict[str, Quantity]:
    span = robot.footprint()
    caster = robot.caster_contact()
    return {
        **{
            name: Quantity(span[axis][1] - span[axis][0], "m", _from_to(axis, *span[axis]))
            for name, axis in (("length", "x"), ("width", "y"), ("height", "z"))
        },
        "height, visual parts included": Quantity(robot.overall_height(), "m"),
        "circumscribed radius": Quantity(robot.circumscribed_radius(), "m", "about the middle of the axle"),
        "caster": Quantity(None, "", "none") if caster is None else _vector(caster, "m", "x, y, z where it stands"),
    }


def _from_to(axis: str, low: float, high: float) -> str:
    return f"{axis} from {round(low, 4) + 0.0:.4f} to {round(high, 4) + 0.0:.4f}"


def _ring(robot: RobotModel, name: str) -> dict[str, Quantity]:
    ring = robot.rangefinder_rings()[name]
    return {
        "beams": Quantity(ring.beams, ""),
        "field of view": Quantity(float(np.rad2deg(ring.field_of_view)), "deg", "from the first beam to the last"),
        "place": _vector(ring.place, "m", "x, y, z in the frame of base, middle of them all"),
        "range": _limit(ring.range or np.inf, "m"),
    }


def _vector(values: FloatArray, unit: str, note: str) -> Quantity:
    return Quantity([float(value) for value in values], unit, note)


def _limit(value: float, unit: str, note: str = "") -> Quantity:
    return Quantity(float(value), unit, note) if np.isfinite(value) else Quantity(None, unit, "not limited")


def table(sections: Sections) -> str:
    """The quantities as aligned lines, section by section."""
    rows = [(name, _text(quantity), quantity) for section in sections.values() for name, quantity in section.items()]
    first = max(len(name) for name, *_ in rows)
    second = max(len(text) for _, text, quantity in rows if quantity.unit or quantity.note)
    lines: list[str] = []
    for title, section in sections.items():
        lines += ["", title] if lines else [title]
        for name, quantity in section.items():
            line = f"  {name:<{first}}  {_text(quantity):<{second}}  {quantity.unit:<10}  {quantity.note}"
            lines.append(line.rstrip())
    return "\n".join(lines)


def _text(quantity: Quantity) -> str:
    if quantity.value is None:
        return "–"
    values = quantity.value if isinstance(quantity.value, list) else [quantity.value]
    return ", ".join(value if isinstance(value, str) else f"{value + 0.0:.4g}" for value in _rounded(values))


def _rounded(values: Sequence[float | str]) -> list[float | str]:
    """Set rounding errors around zero to zero."""
    return [value if isinstance(value, str) or abs(value) > 1e-12 else 0.0 for value in values]


def main(arguments: Sequence[str]) -> None:
    """Print."""
    parsed = parse_arguments(RobotFiguresArguments, arguments)
    physics = open_scene(scene_file(parsed.scene))
    sections = measure_robot(RobotModel(physics.model.ptr))
    if parsed.json:
        plain = {title: {name: f._asdict() for name, f in section.items()} for title, section in sections.items()}
        print(json.dumps(plain, ensure_ascii=False, indent=2))
    else:
        print(table(sections))


if __name__ == "__main__":
    run(main, help_text(__doc__, RobotFiguresArguments))
