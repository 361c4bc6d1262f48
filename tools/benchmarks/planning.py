"""Cost of planning and localisation in the office: a decision of DWA, a global plan, an update of AMCL."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from asddpg.build import make_environment, navigation_env
from asddpg.command_line import train_config
from asddpg.drivers.room_map import draw_room_map
from asddpg.drivers.simulated_robot import SimulatedRobot
from asddpg.episodes.loop import run_episode
from asddpg.planning import navigator
from asddpg.planning.amcl import AMCL, AMCLOptions
from asddpg.planning.dwa import DWA
from asddpg.planning.move_base import MoveBase
from tasks.evaluation_pairs import stored_pairs

TASK = "nav_office"
EPISODES, UPDATES, PARTICLES = 10, 200, 1000
BARS = {"decision of DWA": 3.0, "global plan": 30.0, "update of AMCL": 5.0}  # ms, medians


def planning() -> None:
    """Print the median CPU of each, ms, with its bar."""
    config = train_config([f"task={TASK}", "task.min_linear_velocity=0"])
    environment = make_environment(config.task, config.reward)
    inner = navigation_env(environment)
    room_map = draw_room_map(inner.obstacles)
    robot = SimulatedRobot(inner, room_map)
    pairs = stored_pairs(TASK, "validation", config.task.goal_radius)[:EPISODES]
    driver = MoveBase(robot)
    seconds: dict[str, list[float]] = {name: [] for name in BARS}
    with (
        _timed(DWA, "choose", seconds["decision of DWA"]),
        _timed(navigator, "plan_path", seconds["global plan"]),
        _timed(AMCL, "update", seconds["update of AMCL"]),
    ):
        for pair in pairs:
            run_episode(environment, driver, options=pair.reset_options)
        options = AMCLOptions(min_particles=PARTICLES, max_particles=PARTICLES, update_distance=0.0, update_angle=0.0)
        amcl = AMCL(room_map, robot.shape.max_range, np.random.default_rng(0), (*robot.shape.laser, 0.0), options)
        observation, _ = environment.reset(options=pairs[0].reset_options)
        reading = robot.read(observation)
        amcl.start_at(reading.pose, np.array([0.1, 0.1, 0.1]))
        for step in range(UPDATES):
            pose = (reading.pose[0] + 0.001 * step, reading.pose[1], reading.pose[2])
            amcl.update(pose, reading.ranges, robot.shape.beams)
    for name, values in seconds.items():
        median, most = (float(np.quantile(values, share)) * 1e3 for share in (0.5, 0.95))
        print(
            f"{name:16} {median:5.2f} ms (bar: at most {BARS[name]:g}), 95 % within {most:.2f}, {len(values)} of them"
        )


@contextmanager
def _timed(owner: Any, name: str, seconds: list[float]) -> Iterator[None]:
    """Note the CPU seconds of each call of a function or method."""
    inner: Callable[..., Any] = getattr(owner, name)

    def call(*arguments: Any, **options: Any) -> Any:
        begun = time.process_time()
        try:
            return inner(*arguments, **options)
        finally:
            seconds.append(time.process_time() - begun)

    setattr(owner, name, call)
    try:
        yield
    finally:
        setattr(owner, name, inner)
