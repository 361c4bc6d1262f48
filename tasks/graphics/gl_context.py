"""An OpenGL context without a window: what MUJOCO_GL names, else EGL's, else OSMesa's."""

import importlib
import os
import sys
from typing import Any

from tasks.errors import TaskError

MODULES = {"egl": "mujoco.egl", "osmesa": "mujoco.osmesa", "glfw": "mujoco.glfw"}
LIBRARIES = {"egl": "libEGL or libGL", "osmesa": "libOSMesa", "glfw": "libglfw or a screen"}
PACKAGES = {
    "egl": "libegl1 libgl1 libgl1-mesa-dri",
    "osmesa": "libosmesa6 libgl1",
    "glfw": "libglfw3 libgl1 libgl1-mesa-dri",
}
_SWITCH = "MUJOCO_GL"


def open_context(width: int, height: int) -> Any:
    """A context for pictures of width × height pixels, made current.

    Raises:
        TaskError: no graphics library works, or MUJOCO_GL names none that renders.
    """
    backend = os.environ.get(_SWITCH, "").strip().lower()
    if backend:
        if backend not in MODULES:
            raise TaskError(f"{_SWITCH}={backend} renders no pictures; {', '.join(MODULES)} do, or leave it unset")
        return _open(backend, width, height)
    try:
        return _open("egl", width, height)
    except TaskError as egl_error:
        return _open_osmesa_or_raise(egl_error, width, height)


def missing_graphics_error(backend: str, error: Exception) -> TaskError:
    """The error that says which graphics library fails and which packages bring it."""
    # What PyOpenGL raises for a missing library is "'NoneType' object has no attribute …".
    reason = f"{LIBRARIES[backend]} is missing" if isinstance(error, AttributeError) else " ".join(str(error).split())
    return TaskError(
        f"pictures need a graphics library, and {backend} does not work ({reason.rstrip('.')}); on Debian: "
        f"apt-get install --no-install-recommends {PACKAGES[backend]}"
    )


def _open(backend: str, width: int, height: int) -> Any:
    try:
        context = importlib.import_module(MODULES[backend]).GLContext(width, height)
        context.make_current()
    except (ImportError, AttributeError, RuntimeError, OSError) as error:
        raise missing_graphics_error(backend, error) from error
    return context


def _open_osmesa_or_raise(egl_error: TaskError, width: int, height: int) -> Any:
    """OSMesa in place of EGL; where that fails too, EGL's error."""
    _unload_pyopengl()
    os.environ[_SWITCH] = "osmesa"  # MuJoCo's library reads there which library has OpenGL's functions
    try:
        return _open("osmesa", width, height)
    except TaskError:
        del os.environ[_SWITCH]
        _unload_pyopengl()
        raise egl_error from None


def _unload_pyopengl() -> None:
    """Let PyOpenGL be imported anew: it keeps the platform of its first import."""
    os.environ.pop("PYOPENGL_PLATFORM", None)
    for name in [*sys.modules]:
        if name.split(".")[0] == "OpenGL" or name.startswith(("mujoco.egl", "mujoco.osmesa")):
            del sys.modules[name]
