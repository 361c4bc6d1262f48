"""Drive the robot by keyboard in MuJoCo's viewer: `python -m tools.teleop nav_complex`.

A room without the robot gets one.
"""

import queue
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

import tasks
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks.options import argument
from tasks.physics import Physics, Velocity
from tasks.registry import make_rule, task_model
from tasks.robots.names import PIONEER, SHIPPED
from tasks.room_geometry.start_goal import PairRule
from tasks.scene.checks import find_missing_elements
from tasks.scene.loading import robot_physics
from tools.robot.scene_argument import SCENE, robot_option, scene_model
from tools.robot.teleop_keys import BACKSPACE, help_lines, next_command
from tools.robot.viewer import check_screen, open_viewer, wait_for_frames

FRAME = 0.02  # s between two pictures; the command may change with each


@dataclass(frozen=True)
class TeleopArguments:
    """The scene to drive in."""

    scene: str = argument("A task, a robot's name for it on an open floor, an .xml scene, or a room.", values=SCENE)
    robot: str = robot_option()


class TeleopSession:
    """The robot in a scene, driven by keys.

    Attributes:
        frame: seconds of a frame of advance().
        command: forward speed and turn rate that the wheels are to reach.
    """

    def __init__(self, physics: Physics, rule: PairRule | None = None) -> None:
        """Begin at the start; with a rule each reset draws start and goal by it."""
        self.physics = physics
        self._rng = np.random.default_rng()
        self._rule = rule
        self._steps = max(1, round(FRAME / physics.timestep()))
        self.frame = self._steps * physics.timestep()
        self.reset()

    def reset(self) -> None:
        """Return to the start, which is the first keyframe where there is one."""
        self.command = Velocity(0.0, 0.0)
        physics = self.physics
        physics.reset(keyframe_id=0 if physics.model.ptr.nkey else None)
        if self._rule is not None:
            start, goal = self._rule.draw(self._rng, np.zeros((0, 2)))
            with physics.reset_context():
                physics.set_pose(start)
                physics.set_goal(*goal)

    def press(self, key: int) -> None:
        """Handle a key, GLFW's code."""
        self.command = next_command(self.command, key, self.physics.drive.task_limits)
        if key == BACKSPACE:
            self.reset()

    def advance(self, frames: int = 1) -> None:
        """Simulate some frames at the present command."""
        self.physics.set_velocity_command(*self.command)
        self.physics.step(frames * self._steps)

    def status(self) -> dict[str, str]:
        """Velocities, commands, distance and contacts as text, by name."""
        command, readings = self.command, self.physics.readings()
        return {
            "v": f"{readings.velocity.linear:+.2f} m/s, command {command.linear:+.2f}",
            "omega": f"{readings.velocity.angular:+.2f} rad/s, command {command.angular:+.2f}",
            "to the goal": f"{readings.goal_distance:.2f} m",
            "crashed": "yes" if self.physics.crashed() else "no",
            "pushed": f"{self.physics.num_pushed()} things",
        }


def drive(driven: TeleopSession) -> None:
    """The viewer with teleop, until its window is closed."""
    keys: queue.SimpleQueue[int] = queue.SimpleQueue()
    data = driven.physics.data.ptr
    with open_viewer(driven.physics.model.ptr, data, keys.put) as viewer:
        for frames in wait_for_frames(driven.frame):
            with viewer.lock():
                while not keys.empty():
                    driven.press(keys.get())
                driven.advance(frames)
            status, now = driven.status(), data.time
            corner = mujoco.mjtGridPos.mjGRID_BOTTOMLEFT
            viewer.set_texts((None, corner, "\n".join(status), "\n".join(status.values())))
            viewer.sync()
            if data.time < now:  # the viewer's own reset button
                driven.reset()
            if not viewer.is_running():
                return


def main(arguments: Sequence[str]) -> None:
    """Open the scene and drive."""
    parsed = parse_arguments(TeleopArguments, arguments)
    scene, robot = parsed.scene, parsed.robot
    model = scene_model(scene, robot)
    is_task = scene in tasks.ALL_TASKS or not scene.endswith(".xml") or robot != PIONEER
    check_screen()
    if find_missing_elements(model):
        print(f"{scene} has no robot: the Pioneer is put into it")
        model, is_task = task_model(scene), True
    physics = robot_physics(model, scene)
    lines = help_lines(physics.drive.task_limits)
    print("\n".join(f"  {keys:<12} {meaning}" for keys, meaning in lines), flush=True)
    drive(TeleopSession(physics, make_rule(scene, model) if is_task and scene not in SHIPPED else None))


if __name__ == "__main__":
    run(main, help_text(__doc__, TeleopArguments))
