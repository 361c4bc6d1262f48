"""Cost of a control step through Gymnasium, of one robot and of many, against the cheapest loop of the same physics."""

import time
from typing import Any

import gymnasium
import mujoco
import numpy as np

import tasks
from tasks.constants import CONTROL_TIMESTEP
from tasks.physics import FloatArray
from tools.benchmarks.physics import NO_SENSORS, set_command

ROUNDS = 25
# Every loop begins anew every 10 steps, so that no robot ever leans against a wall.
STRETCH = 10
LARGEST_RATIO, SMALLEST_SHARE = 1.15, 0.85
THREADS = 2


def environment() -> None:
    """Print the cost of a step of one robot as a multiple of the raw loop's."""
    env = gymnasium.make(tasks.gymnasium_id("nav_complex"))
    env.reset(seed=0)
    scene = env.get_wrapper_attr("physics")
    commands = _draw_commands(200)
    ratios, ours, raws = [], [], []
    for _ in range(ROUNDS):
        raws.append(_raw_loop(scene.model.ptr, commands))
        ours.append(_gymnasium_loop(env, commands))
        ratios.append(ours[-1] / raws[-1])
    print(f"physics step {scene.timestep() * 1e3:g} ms, {CONTROL_TIMESTEP:g} s a control step, {scene.num_beams} beams")
    print(f"raw loop {np.median(raws) * 1e6:.0f} µs, through Gymnasium {np.median(ours) * 1e6:.0f} µs a control step")
    print(
        f"ratio {np.median(ratios):.3f} (bar: at most {LARGEST_RATIO}; rounds {min(ratios):.3f} to {max(ratios):.3f})"
    )


def vector() -> None:
    """Print the steps a second of many robots in two threads as a share of twice the raw loop's of one."""
    for count in (16, 64):
        env: Any = gymnasium.make_vec(tasks.gymnasium_id("nav_complex"), num_envs=count, num_threads=THREADS)
        env.reset(seed=0)
        commands = _draw_commands(200)
        shares, speeds = [], []
        for _ in range(ROUNDS):
            raw = _raw_loop(env.envs[0].physics.model.ptr, commands)
            ours = _vector_loop(env, _draw_commands(20 * count).reshape(20, count, 2))
            shares.append(raw / THREADS / ours)
            speeds.append(1.0 / ours)
        env.close()
        print(
            f"{count} robots, {THREADS} threads: {np.median(speeds):.0f} control steps/s, {np.median(shares):.3f} of "
            f"{THREADS} raw loops (bar: at least {SMALLEST_SHARE}; rounds {min(shares):.3f} to {max(shares):.3f})"
        )


def _draw_commands(count: int) -> FloatArray:
    return np.random.default_rng(0).uniform([0.0, -1.0], [0.5, 1.0], (count, 2))


def _raw_loop(model: mujoco.MjModel, commands: FloatArray) -> float:
    """Seconds a control step."""
    data, flags, seconds = mujoco.MjData(model), model.opt.disableflags, 0.0
    substeps = round(CONTROL_TIMESTEP / model.opt.timestep)
    for index, command in enumerate(commands):
        if index % STRETCH == 0:
            mujoco.mj_resetData(model, data)
            mujoco.mj_forward(model, data)
        begun = time.perf_counter()
        set_command(data, *command)
        model.opt.disableflags = flags | NO_SENSORS
        mujoco.mj_step(model, data, substeps - 1)
        model.opt.disableflags = flags
        mujoco.mj_step(model, data, 1)
        seconds += time.perf_counter() - begun
    return seconds / len(commands)


def _gymnasium_loop(env: gymnasium.Env[Any, Any], commands: FloatArray) -> float:
    """Seconds a control step."""
    seconds, fresh = 0.0, False
    for index, command in enumerate(commands):
        if index % STRETCH == 0 or not fresh:
            env.reset()
        begun = time.perf_counter()
        _, _, terminated, truncated, _ = env.step(command)
        seconds += time.perf_counter() - begun
        fresh = not (terminated or truncated)
    return seconds / len(commands)


def _vector_loop(env: gymnasium.vector.VectorEnv[Any, Any, Any], commands: FloatArray) -> float:
    """Seconds a control step of one robot, resets after an end among them."""
    seconds = 0.0
    for index, actions in enumerate(commands):
        if index % STRETCH == 0:
            env.reset()
        begun = time.perf_counter()
        env.step(actions)
        seconds += time.perf_counter() - begun
    return seconds / (len(commands) * env.num_envs)
