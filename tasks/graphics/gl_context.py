"""An OpenGL context without a window: EGL's where MUJOCO_GL asks for nothing else, or else OSMesa's if it is there."""

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
        TaskError: no graphics library that works, or MUJOCO_GL names none.
    """
    asked_for = os.environ.get(_SWITCH, "").strip().lower()
    if asked_for:
        if asked_for not in MODULES:
            raise TaskError(f"{_SWITCH}={asked_for} renders no pictures; {', '.join(MODULES)} do, or leave it unset")
        return _open(asked_for, width, height)
    try:
        return _open("egl", width, height)
    except TaskError as no_egl:
        return _open_osmesa_or_raise(no_egl, width, height)


def graphics_missing(backend: str, error: Exception) -> TaskError:
    """The sentence for a graphics library that fails."""
    # What PyOpenGL raises for a missing library is "'NoneType' object has no attribute …".
    why = f"{LIBRARIES[backend]} is missing" if isinstance(error, AttributeError) else " ".join(str(error).split())
    return TaskError(
        f"pictures need a graphics library, and {backend} does not work ({why.rstrip('.')}); on Debian: "
        f"apt-get install --no-install-recommends {PACKAGES[backend]}"
    )


def _open(backend: str, width: int, height: int) -> Any:
    try:
        context = importlib.import_module(MODULES[backend]).GLContext(width, height)
        context.make_current()
    except (ImportError, AttributeError, RuntimeError, OSError) as error:
        raise graphics_missing(backend, error) from error
    return context


def _open_osmesa_or_raise(no_egl: TaskError, width: int, height: int) -> Any:
    """OSMesa in place of EGL; where that fails too, EGL's sentence."""
    _forget_pyopengl()
    os.environ[_SWITCH] = "osmesa"  # MuJoCo's library looks there for where to take OpenGL's functions from
    try:
        return _open("osmesa", width, height)
    except TaskError:
        del os.environ[_SWITCH]
        _forget_pyopengl()
        raise no_egl from None


def _forget_pyopengl() -> None:
    """Let PyOpenGL be imported anew: it keeps to the platform that it was first imported for."""
    os.environ.pop("PYOPENGL_PLATFORM", None)
    for name in [*sys.modules]:
        if name.split(".")[0] == "OpenGL" or name.startswith(("mujoco.egl", "mujoco.osmesa")):
            del sys.modules[name]
