"""Properties of the robot, from the compiled model: `python -m tools.robot_figures`."""

import json
from collections.abc import Sequence
from dataclasses import dataclass

from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks.options import argument, option
from tasks.robots.names import PIONEER, SHIPPED
from tasks.robots.opening import load_robot, measure_speeds
from tasks.scene.loading import robot_physics
from tools.robot.robot_quantities import Quantity, RobotQuantities, Section, driven_section
from tools.robot.scene_argument import SCENE, robot_option, scene_model


@dataclass(frozen=True)
class RobotFiguresArguments:
    """The scene with the robot, and the form of its figures."""

    scene: str = argument("A task, a robot's name for it alone, or a path to an .xml scene with it.", PIONEER, SCENE)
    robot: str = robot_option()
    json: bool = option(False, "Whether they are printed as JSON, for machines.")


def table(sections: dict[str, Section]) -> str:
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
    return ", ".join(value if isinstance(value, str) else f"{round(value, 12) + 0.0:.4g}" for value in values)


def main(arguments: Sequence[str]) -> None:
    """Print."""
    parsed = parse_arguments(RobotFiguresArguments, arguments)
    model = scene_model(parsed.scene, parsed.robot)
    sections = RobotQuantities(robot_physics(model, parsed.scene).model.ptr).sections
    if parsed.scene in SHIPPED:
        robot = parsed.scene if parsed.robot == PIONEER else parsed.robot
        sections["commanded and driven"] = driven_section(measure_speeds(load_robot(robot), robot))
    if parsed.json:
        plain = {title: {name: f._asdict() for name, f in section.items()} for title, section in sections.items()}
        print(json.dumps(plain, ensure_ascii=False, indent=2))
    else:
        print(table(sections))


if __name__ == "__main__":
    run(main, help_text(__doc__, RobotFiguresArguments))
