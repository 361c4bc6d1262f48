"""Pictures: the graphics library, the errors without one, and no effect on the simulation."""

import os
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import tasks
from tasks.errors import TaskError
from tasks.graphics import gl_context
from tasks.graphics.rendering import OffscreenRenderer
from tests.conftest import ROOT

# As if no graphics library were installed: PyOpenGL asks ctypes for all of them.
WITHOUT_GRAPHICS = """
import ctypes, ctypes.util
GRAPHICS = ("EGL", "GL", "OpenGL", "GLU", "GLESv1", "GLESv2", "OSMesa", "glfw")
def is_graphics(name):
    return bool(name) and any(str(name).split("/")[-1].startswith(p + s) for g in GRAPHICS for p in (g, "lib" + g)
                              for s in (".", "_")) or name in GRAPHICS
find, load = ctypes.util.find_library, ctypes.CDLL.__init__
def no_load(self, name, *args, **options):
    if is_graphics(name):
        raise OSError(f"{name}: cannot open shared object file: No such file or directory")
    load(self, name, *args, **options)
ctypes.util.find_library = lambda name: None if is_graphics(name) else find(name)
ctypes.CDLL.__init__ = no_load
"""


@pytest.mark.slow
def test_without_graphics_libraries_all_but_pictures_works(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(WITHOUT_GRAPHICS)
    script = tmp_path / "script.py"
    script.write_text(
        """
from asddpg import evaluate, train
from tasks.errors import TaskError

arguments = ["agent=controller", "task=nav_empty", "episodes=1", "record.every=1"]
evaluate.main(arguments)
arguments = ["task=nav_empty", "total_steps=30", "test_episodes=0", "validation.every=0", "record.every=1"]
train.main([*arguments, "run_dir=with"])
try:
    train.main([*arguments, "record.cameras=[chase]", "run_dir=without"])
except TaskError as error:
    print("SENTENCE", error)
"""
    )
    environment = {name: value for name, value in os.environ.items() if name not in ("MUJOCO_GL", "PYOPENGL_PLATFORM")}
    for asked_for in ({}, {"MUJOCO_GL": "egl"}):
        folder = tmp_path / asked_for.get("MUJOCO_GL", "unset")
        folder.mkdir()
        done = subprocess.run(
            [sys.executable, str(script)],
            cwd=folder,
            env={**environment, **asked_for, "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        (sentence,) = (line for line in done.stdout.splitlines() if line.startswith("SENTENCE"))
        assert "libegl1 libgl1" in sentence
        assert "libEGL or libGL is missing" in sentence
        assert list(folder.glob("evaluated_episodes/*.mcap"))
        assert list(folder.glob("with/episodes/*.mcap"))
        assert not (folder / "without").exists()  # refused before anything was written


def fake(name: str, monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, int]]:
    """A module with a graphics context, by that name; returns the sizes it is asked for."""
    made: list[tuple[int, int]] = []

    class GLContext:
        def __init__(self, width: int, height: int) -> None:
            made.append((width, height))

        def make_current(self) -> None:
            pass

        free = make_current

    module = ModuleType(name)
    module.GLContext = GLContext  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, name, module)
    return made


def use(modules: dict[str, str], asked_for: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gl_context, "MODULES", {"egl": "no_egl", "osmesa": "no_osmesa", "glfw": "no_glfw", **modules})
    monkeypatch.setattr(gl_context, "_unload_pyopengl", lambda _: None)  # the other tests' is loaded
    monkeypatch.setattr(gl_context, "_opened", set())
    monkeypatch.setenv("MUJOCO_GL", asked_for or "")


def test_osmesa_replaces_egl_where_egl_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    made = fake("fake_osmesa", monkeypatch)
    use({"osmesa": "fake_osmesa"}, None, monkeypatch)
    # MuJoCo's library reads MUJOCO_GL, and so do others.
    _, seen = gl_context.open_context(64, 48, lambda: os.environ["MUJOCO_GL"])
    assert made == [(64, 48)]
    assert (seen, os.environ["MUJOCO_GL"]) == ("osmesa", "")


@pytest.mark.parametrize(("osmesa", "asked_for"), [("fake_osmesa", "egl"), ("no_osmesa", None)])
def test_the_error_is_egls_where_it_is_asked_for_and_where_osmesa_fails_too(
    osmesa: str, asked_for: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = fake("fake_osmesa", monkeypatch)
    use({"osmesa": osmesa}, asked_for, monkeypatch)
    with pytest.raises(TaskError, match=r"egl does not work \(No module named 'no_egl'\).*libegl1 libgl1"):
        gl_context.open_context(64, 48, lambda: None)
    assert made == []
    assert os.environ.get("MUJOCO_GL", "") == (asked_for or "")


def test_a_name_that_renders_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with pytest.raises(TaskError, match="MUJOCO_GL=disable renders no pictures; egl, osmesa, glfw do"):
        gl_context.open_context(64, 48, lambda: None)


@pytest.mark.parametrize(
    ("name", "value", "reason", "advice"),
    [
        ("MUJOCO_EGL_DEVICE_ID", "99", "'99' names no device", "unset MUJOCO_EGL_DEVICE_ID"),
        ("MUJOCO_EGL_DEVICE_ID", "first", "'first' names no device", "unset MUJOCO_EGL_DEVICE_ID"),
        ("PYOPENGL_PLATFORM", "glx", "PYOPENGL_PLATFORM is glx", "unset PYOPENGL_PLATFORM"),
        ("MESA_GL_VERSION_OVERRIDE", "1.1", "OpenGL version 1.5 or higher required", "a newer driver"),
        ("__EGL_VENDOR_LIBRARY_FILENAMES", "/none", "Cannot initialize", "apt-get install .* libegl1"),
        ("MUJOCO_GL", "glfw", "DISPLAY names none that opens", "MUJOCO_GL=egl"),
    ],
)
def test_the_advice_fits_the_cause_at_each_attempt(name: str, value: str, reason: str, advice: str) -> None:
    code = """
import tasks
physics = tasks.load("nav_empty").physics
for _ in range(2):
    try:
        physics.render()
    except tasks.errors.TaskError as error:
        print(error)
"""
    absent = ("MUJOCO_GL", "DISPLAY", "WAYLAND_DISPLAY", "PYOPENGL_PLATFORM")
    environment = {key: kept for key, kept in os.environ.items() if key not in absent} | {name: value}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=60, check=False)
    first, second = done.stdout.splitlines()
    assert first == second
    assert re.search(f"{reason}.*{advice}", first), first
    assert ("apt-get" in first) == ("apt-get" in advice)
    assert done.stderr == ""


def test_two_renderers_take_turns() -> None:
    environment = tasks.load("nav_empty", random=0)
    environment.reset()
    physics = environment.physics
    small, large = (OffscreenRenderer(physics.model.ptr, 4 * size, 3 * size) for size in (8, 16))
    try:
        first = small.render(physics.data.ptr, "top")
        assert large.render(physics.data.ptr, "chase").shape == (48, 64, 3)
        assert np.array_equal(small.render(physics.data.ptr, "top"), first)
    finally:
        small.close()
        large.close()


def test_pictures_change_nothing_in_the_simulation() -> None:
    states = []
    for is_watched in (False, True):
        environment = tasks.load("nav_gazebo", random=0)
        environment.reset()
        physics = environment.physics
        renderer = OffscreenRenderer(physics.model.ptr, 32, 24) if is_watched else SimpleNamespace(close=lambda: None)
        for _ in range(5):
            environment.step([0.4, 0.3])
            if isinstance(renderer, OffscreenRenderer):
                renderer.render(physics.data.ptr, "onboard")
        renderer.close()
        states.append(np.concatenate((physics.data.ptr.qpos, physics.data.ptr.qvel, physics.data.ptr.sensordata)))
    assert np.array_equal(states[0], states[1])
