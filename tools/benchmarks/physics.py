"""Cost and accuracy of the physics, for tools.bench."""

import math
import time
from collections.abc import Callable
from functools import partial

import mujoco
import numpy as np

from tasks.constants import CONTROL_TIMESTEP, TRACK, WHEEL_RADIUS
from tasks.physics import FloatArray
from tasks.registry import ALL_TASKS, load, make_rule
from tasks.room_geometry.held_out import held_out_goals
from tasks.scene.loading import load_model, scene_path

REFERENCE = 0.00025  # s
TIMESTEPS = (0.001, 0.002, 0.005, 0.01)  # s
SECONDS, SEQUENCES = 5.0, 8
NO_SENSORS = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)


def timestep() -> None:
    """Print the cost of physics steps of 1 to 10 ms and their error.

    The robot drives SECONDS of random commands on a free floor, SEQUENCES times. The error is the largest difference of
    the final pose from that with a reference step and from that with half the step.
    """
    reference = _final_poses(REFERENCE)
    print(f"against {REFERENCE * 1e3:g} ms and against half the step, {SEQUENCES} drives of {SECONDS:g} s")
    costs = {step: _seconds_per_control_step(step) for step in TIMESTEPS}
    for step in TIMESTEPS:
        ends = _final_poses(step)
        from_reference, from_half = _differences(ends, reference), _differences(ends, _final_poses(step / 2))
        cost = costs[step] / costs[0.005]
        print(f"{step * 1e3:4g} ms: {cost:.2f} of the time of 5 ms; {from_reference} from the reference, ", end="")
        print(f"{from_half} from half the step")


def laser() -> None:
    """Print the cost of a scan: a control step with 40 and with 682 beams against the same physics without rays."""
    seconds = _measure_alternating({str(count): _loop("nav_complex", count) for count in (None, 40, 682)})
    for count, bar in (("40", " (bar: at most 1.25)"), ("682", "")):
        ratio = np.median(np.divide(seconds[count], seconds["None"]))
        print(f"nav_complex, {count} beams: {ratio:.3f} times the physics without rays{bar}")


def rooms() -> None:
    """Print the cost of a control step in each room, the robot turning on the spot, against nav_complex."""
    seconds = _measure_alternating({name: _loop(name, 40) for name in ALL_TASKS})
    for name in ALL_TASKS:
        ratio = np.median(np.divide(seconds[name], seconds["nav_complex"]))
        print(f"{name}: {np.median(seconds[name]) * 1e6:.0f} us a control step, {ratio:.2f} times nav_complex")


def reset() -> None:
    """Print the cost of a reset with a new start and goal, and the part of drawing them."""
    for name in ALL_TASKS:
        begun = time.perf_counter()
        environment = load(name, random=0)
        loaded = time.perf_counter() - begun
        rule, rng = make_rule(name, environment.physics.model.ptr), np.random.default_rng(0)
        resets, draws = _median_time(environment.reset), _median_time(partial(rule.draw, rng, held_out_goals(name)))
        print(f"{name}: loaded in {loaded:.2f} s; reset {resets}, of that drawing {draws} (bar: under 500 us)")


def _median_time(action: Callable[[], object]) -> str:
    seconds = []
    for _ in range(1000):
        begun = time.perf_counter()
        action()
        seconds.append(time.perf_counter() - begun)
    return f"{np.median(seconds) * 1e6:.0f} us"


def _measure_alternating(loops: dict[str, Callable[[], None]]) -> dict[str, list[float]]:
    """Seconds a call of each, in 15 rounds of alternating calls."""
    seconds: dict[str, list[float]] = {name: [] for name in loops}
    for _ in range(15):
        for name, loop in loops.items():
            begun = time.perf_counter()
            for _ in range(50):
                loop()
            seconds[name].append((time.perf_counter() - begun) / 50)
    return seconds


def _loop(task: str, num_beams: int | None) -> Callable[[], None]:
    """One control step as tasks.Physics does it, with a scan at its end or, for None, without."""
    model = load_model(scene_path(task), num_beams)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    _set_command(data, 0.0, 0.5)
    flags, steps = model.opt.disableflags, round(CONTROL_TIMESTEP / model.opt.timestep)

    def loop() -> None:
        model.opt.disableflags = flags | NO_SENSORS
        mujoco.mj_step2(model, data)
        mujoco.mj_step(model, data, steps - 1)
        if num_beams is not None:
            model.opt.disableflags = flags
        mujoco.mj_step1(model, data)

    return loop


def _set_command(data: mujoco.MjData, linear: float, angular: float) -> None:
    half_turn = 0.5 * TRACK * angular
    data.ctrl[:] = (linear - half_turn) / WHEEL_RADIUS, (linear + half_turn) / WHEEL_RADIUS


def _free_floor(step: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = load_model(scene_path("nav_empty"))
    model.opt.timestep = step
    model.opt.disableflags |= NO_SENSORS
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def _final_poses(step: float) -> FloatArray:
    """Final poses of the drives: (SEQUENCES, 3), metres and radians."""
    ends = []
    for seed in range(SEQUENCES):
        model, data = _free_floor(step)
        rng = np.random.default_rng(seed)
        for _ in range(round(SECONDS / CONTROL_TIMESTEP)):
            _set_command(data, rng.uniform(0.0, 0.5), rng.uniform(-math.pi / 3, math.pi / 3))
            mujoco.mj_step(model, data, round(CONTROL_TIMESTEP / step))
        w, x, y, z = data.qpos[3:7]
        ends.append([*data.qpos[:2], math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))])
    return np.array(ends)


def _differences(ends: FloatArray, others: FloatArray) -> str:
    metres = np.hypot(*(ends - others)[:, :2].T).max()
    turned = (ends - others)[:, 2]
    degrees = np.degrees(np.abs(np.arctan2(np.sin(turned), np.cos(turned)))).max()
    return f"{metres * 100:.1f} cm and {degrees:.2f}°"


def _seconds_per_control_step(step: float) -> float:
    model, data = _free_floor(step)
    _set_command(data, 0.0, 0.5)
    seconds = []
    for _ in range(20):
        begun = time.perf_counter()
        mujoco.mj_step(model, data, round(CONTROL_TIMESTEP / step))
        seconds.append(time.perf_counter() - begun)
    return float(np.median(seconds))
