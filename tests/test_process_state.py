"""Importing this project, and driving and drawing an environment, changes nothing that others in the process see."""

import gc
import importlib
import logging
import os
import pkgutil
import random
import signal
import subprocess
import sys
import threading
import warnings
from pathlib import Path
from typing import Any

import pytest


def process_state() -> dict[str, Any]:
    import matplotlib
    import numpy
    import torch

    loggers = (logging.root, logging.getLogger("absl"))
    return {
        "environment": dict(os.environ),
        "paths": ([*sys.path], [*sys.meta_path], os.getcwd()),
        "warnings": ([*map(str, warnings.filters)], warnings.showwarning),
        "logging": [(log.level, [*log.handlers], [*log.filters], log.disabled) for log in loggers],
        "numpy": (numpy.geterr(), numpy.get_printoptions(), numpy.random.get_state()[1].tolist()),  # type: ignore[index]
        "torch": (torch.get_num_threads(), torch.is_grad_enabled(), torch.get_rng_state().tolist()),
        "denormals": float(torch.tensor(1e-310, dtype=torch.float64) * 1),
        "random": random.getstate(),
        "signals": [signal.getsignal(number) for number in signal.valid_signals()],
        "hooks": (sys.excepthook, sys.displayhook, sys.unraisablehook, threading.excepthook),
        "limits": (sys.getrecursionlimit(), sys.getswitchinterval(), gc.get_threshold(), gc.isenabled()),
        "matplotlib": dict(matplotlib.rcParams),
    }


def import_and_use() -> None:
    for package in ("tasks", "asddpg", "tools"):
        for module in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
            if module.name != "tools.benchmarks.stable_baselines":  # needs an extra, which changes warnings
                importlib.import_module(module.name)
    import gymnasium

    env = gymnasium.make("asddpg/NavEmpty-v0", render_mode="rgb_array")
    env.reset(seed=1)
    env.step(env.action_space.sample())
    env.render()
    env.close()


def print_changes() -> None:
    for library in (
        "gymnasium",
        "scipy.special",
        "scipy.sparse",
        "dm_control.mujoco",
    ):  # they change some of it themselves
        importlib.import_module(library)
    before = process_state()
    import_and_use()
    after = process_state()
    print(*(f"{name}: {before[name]} became {after[name]}" for name in before if before[name] != after[name]))


def print_backend() -> None:
    from dm_control import _render

    print(_render.BACKEND)


def run(code: str, backend: str | None = None) -> str:
    environment = {name: value for name, value in os.environ.items() if name not in ("MUJOCO_GL", "PYOPENGL_PLATFORM")}
    return subprocess.run(
        [sys.executable, "-W", "ignore", "-c", f"from {__name__} import *; {code}"],
        cwd=Path(__file__).parents[1],
        env=environment | ({} if backend is None else {"MUJOCO_GL": backend}),
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    ).stdout


@pytest.mark.slow
def test_everything_imported_and_a_picture_drawn_the_process_is_as_before() -> None:
    assert run("print_changes()") == "\n"


@pytest.mark.parametrize("backend", [None, "egl", "glfw", "disable"])
def test_dm_control_finds_the_graphics_library_that_it_finds_alone(backend: str | None) -> None:
    assert run("import tasks; print_backend()", backend) == run("print_backend()", backend)
