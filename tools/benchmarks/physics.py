"""Cost and accuracy of the physics, for tools.bench."""

import math
import time
from collections.abc import Callable, Mapping
from functools import partial

import mujoco
import numpy as np

from tasks.constants import CONTROL_TIMESTEP, TRACK, WHEEL_RADIUS
from tasks.laser import BeamRing
from tasks.physics import FloatArray
from tasks.registry import ROOM_TASKS, load, make_rule
from tasks.room_geometry.held_out import held_out_goals
from tasks.scene.loading import load_model, scene_path

REFERENCE = 0.00025  # s
TIMESTEPS = (0.001, 0.002, 0.005, 0.01)  # s
SECONDS, SEQUENCES = 5.0, 8
ROUNDS, CALLS = 15, 50
NO_SENSORS = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)


def timestep() -> None:
    """Print the cost of physics steps of 1 to 10 ms and their error.

    The robot drives SECONDS of random commands on a free floor, SEQUENCES times. The error is the largest difference of
    the final pose from that with a reference step and from that with half the step.
    """
    reference = _final_poses(REFERENCE)
    print(f"against {REFERENCE * 1e3:g} ms and against half the step, {SEQUENCES} drives of {SECONDS:g} s")
    costs = _median_costs({str(step): _control_step("nav_empty", None, step) for step in TIMESTEPS})
    for step in TIMESTEPS:
        ends = _final_poses(step)
        from_reference, from_half = _differences(ends, reference), _differences(ends, _final_poses(step / 2))
        cost = costs[str(step)] / costs["0.005"]
        print(f"{step * 1e3:4g} ms: {cost:.2f} of the time of 5 ms; {from_reference} from the reference, ", end="")
        print(f"{from_half} from half the step")


def laser() -> None:
    """Print the cost of a scan: a control step with 40 and with 682 beams against the same physics without rays."""
    seconds = _measure_costs({str(count): _control_step("nav_complex", count) for count in (None, 40, 682)})
    for count, bar in (("40", " (bar: at most 1.25)"), ("682", "")):
        ratio = np.median(seconds[count] / seconds["None"])
        print(f"nav_complex, {count} beams: {ratio:.3f} times the physics without rays{bar}")


def rooms() -> None:
    """Print the cost of a control step in each room, the robot turning on the spot, against nav_complex."""
    seconds = _measure_costs({name: _control_step(name, 40) for name in ROOM_TASKS})
    for name in ROOM_TASKS:
        ratio = np.median(seconds[name] / seconds["nav_complex"])
        print(f"{name}: {np.median(seconds[name]) * 1e6:.0f} us a control step, {ratio:.2f} times nav_complex")


def reset() -> None:
    """Print the cost of a reset with a new start and goal, and the part of drawing them."""
    for name in ROOM_TASKS:
        begun = time.perf_counter()
        environment = load(name, random=0)
        loaded = time.perf_counter() - begun
        rule, rng = make_rule(name, environment.physics.model.ptr), np.random.default_rng(0)
        costs = _median_costs({"reset": environment.reset, "draw": partial(rule.draw, rng, held_out_goals(name))})
        reset, draw = (f"{seconds * 1e6:.0f} us" for seconds in costs.values())
        print(f"{name}: loaded in {loaded:.2f} s; reset {reset}, of that drawing {draw} (bar: under 500 us)")


def _measure_costs(actions: Mapping[str, Callable[[], object]]) -> dict[str, FloatArray]:
    """Seconds a call of each, (ROUNDS,), its calls in turn with those of the others."""
    seconds = {name: np.zeros(ROUNDS) for name in actions}
    for round_ in range(ROUNDS):
        for name, action in actions.items():
            begun = time.perf_counter()
            for _ in range(CALLS):
                action()
            seconds[name][round_] = (time.perf_counter() - begun) / CALLS
    return seconds


def _median_costs(actions: Mapping[str, Callable[[], object]]) -> dict[str, float]:
    return {name: float(np.median(seconds)) for name, seconds in _measure_costs(actions).items()}


def _control_step(task: str, num_beams: int | None, step: float | None = None) -> Callable[[], None]:
    """One control step as tasks.Physics does it, with a scan at its end or, for None, without; `step` in seconds."""
    model = load_model(scene_path(task), None if num_beams is None else BeamRing(num_beams))
    model.opt.timestep = step or model.opt.timestep
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    set_command(data, 0.0, 0.5)
    flags, steps = model.opt.disableflags, round(CONTROL_TIMESTEP / model.opt.timestep)

    def advance() -> None:
        model.opt.disableflags = flags | NO_SENSORS
        mujoco.mj_step2(model, data)
        mujoco.mj_step(model, data, steps - 1)
        if num_beams is not None:
            model.opt.disableflags = flags
        mujoco.mj_step1(model, data)

    return advance


def set_command(data: mujoco.MjData, linear: float, angular: float) -> None:
    """Command the wheels' speeds for a forward speed (m/s) and a turn rate (rad/s), without limits."""
    half_turn = 0.5 * TRACK * angular
    data.ctrl[:] = (linear - half_turn) / WHEEL_RADIUS, (linear + half_turn) / WHEEL_RADIUS


def _final_poses(step: float) -> FloatArray:
    """Final poses of the drives: (SEQUENCES, 3), metres and radians."""
    model = load_model(scene_path("nav_empty"))
    model.opt.timestep = step
    model.opt.disableflags |= NO_SENSORS
    ends = []
    for seed in range(SEQUENCES):
        data, rng = mujoco.MjData(model), np.random.default_rng(seed)
        mujoco.mj_forward(model, data)
        for _ in range(round(SECONDS / CONTROL_TIMESTEP)):
            set_command(data, rng.uniform(0.0, 0.5), rng.uniform(-math.pi / 3, math.pi / 3))
            mujoco.mj_step(model, data, round(CONTROL_TIMESTEP / step))
        w, x, y, z = data.qpos[3:7]
        ends.append([*data.qpos[:2], math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))])
    return np.array(ends)


def _differences(ends: FloatArray, others: FloatArray) -> str:
    differences = ends - others
    metres = np.hypot(*differences[:, :2].T).max()
    degrees = np.degrees(np.abs(np.arctan2(np.sin(differences[:, 2]), np.cos(differences[:, 2]))).max())
    return f"{metres * 100:.1f} cm and {degrees:.2f}°"
