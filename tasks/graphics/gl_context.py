"""An OpenGL context without a window: what MUJOCO_GL names, else EGL's, else OSMesa's."""

import atexit
import contextlib
import importlib
import multiprocessing
import os
import sys
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import mujoco

from tasks.errors import TaskError

T = TypeVar("T")

MODULES = {"egl": "mujoco.egl", "osmesa": "mujoco.osmesa", "glfw": "mujoco.glfw"}
LIBRARIES = {"egl": "libEGL or libGL", "osmesa": "libOSMesa", "glfw": "libglfw"}
PACKAGES = {
    "egl": "libegl1 libgl1 libgl1-mesa-dri",
    "osmesa": "libosmesa6 libgl1",
    "glfw": "libglfw3 libgl1 libgl1-mesa-dri",
}
_SWITCH, _PLATFORM, _DEVICE = "MUJOCO_GL", "PYOPENGL_PLATFORM", "MUJOCO_EGL_DEVICE_ID"
_SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")
_ANY = ("", "1", "on", "true", "enable", "enabled")  # as mujoco and dm_control read MUJOCO_GL
_EGL_DISPLAYS = ("mujoco.egl", "dm_control._render.pyopengl.egl_renderer")
_SECOND_DISPLAY = "second display"
_SURFACELESS = 0x31DD  # EGL_PLATFORM_SURFACELESS_MESA

_opened: set[str] = set()  # libraries with which this process opened a context
_inherited: set[str] = set()  # libraries that were open when this process was forked


def open_context(width: int, height: int, make: Callable[[], T]) -> tuple[Any, T]:
    """A context for pictures of width × height pixels, made current in this thread, and what `make` makes with it.

    Raises:
        TaskError: no graphics library works, or MUJOCO_GL names none that renders.
    """
    backend = os.environ.get(_SWITCH, "").strip().lower()
    if backend not in (*MODULES, *_ANY):
        raise TaskError(f"{_SWITCH}={backend} renders no pictures; {', '.join(MODULES)} do, or leave it unset")
    if backend not in _ANY:
        return _open(backend, width, height, make)
    if "osmesa" in _opened | _inherited:
        return _open("osmesa", width, height, make)
    loaded = {*sys.modules}
    try:
        return _open("egl", width, height, make)
    except TaskError as egl_error:
        _unload_pyopengl(loaded)
        try:
            return _open("osmesa", width, height, make)
        except TaskError:
            _unload_pyopengl(loaded)
            raise egl_error from None


def forget_contexts() -> None:
    """In a forked process: the contexts of its parent are of no use."""
    for name in _EGL_DISPLAYS:
        if getattr(sys.modules.get(name), "EGL_DISPLAY", None):
            _opened.add("egl")
            atexit.unregister(sys.modules[name].EGL.eglTerminate)  # hangs: the display's threads stayed in the parent
    _inherited.update(_opened)
    _opened.clear()


def _open(backend: str, width: int, height: int, make: Callable[[], T]) -> tuple[Any, T]:
    try:
        with _environment(MUJOCO_GL=backend), contextlib.ExitStack() as undo:  # MuJoCo's library reads MUJOCO_GL too
            module = _library(backend)
            context = module.GLContext(width, height)
            if backend == "egl":
                # Others may use the display too, dm_control and mujoco.Renderer: what they free later would raise.
                atexit.unregister(module.EGL.eglTerminate)
            undo.callback(context.free)
            context.make_current()
            made = make()
            undo.pop_all()
    except TaskError:
        raise
    except Exception as error:  # those of PyOpenGL, ctypes, glfw and MuJoCo have no common class
        raise _error(backend, error) from error
    _opened.add(backend)
    return context, made


def _library(backend: str) -> Any:
    """The module of MuJoCo for a graphics library, ready to open a context."""
    module: Any = importlib.import_module(MODULES[backend])
    if backend in _inherited and backend not in _opened:
        _open_second_display(backend, module)
    elif backend == "egl" and not module.EGL_DISPLAY:
        module.EGL_DISPLAY = None  # mujoco keeps the display that it failed to open
    elif backend == "glfw" and not (any(map(os.environ.get, _SCREENS)) and module.glfw.init()):
        raise TaskError(f"{_SWITCH}=glfw needs a screen, and DISPLAY names none that opens; {_SWITCH}=egl needs none")
    return module


def _error(backend: str, error: Exception) -> TaskError:
    """The error of a graphics library that fails: cause and remedy."""
    reason = " ".join(str(error).split()).rstrip(".")
    platform, device = os.environ.get(_PLATFORM, backend), os.environ.get(_DEVICE)
    advice = f"on Debian: apt-get install --no-install-recommends {PACKAGES[backend]}"
    if platform.lower() != backend:
        reason, advice = f"{_PLATFORM} is {platform}", f"unset {_PLATFORM}"
    elif isinstance(error, AttributeError):  # PyOpenGL's is "'NoneType' object has no attribute …"
        reason = f"{LIBRARIES[backend]} is missing"
    elif isinstance(error, mujoco.FatalError):
        advice = "a newer driver has what MuJoCo needs, or MUJOCO_GL=osmesa draws without one"
    elif backend == "egl" and device is not None:
        reason = f"{_DEVICE}={device!r} names no device that can be opened"
        advice = f"unset {_DEVICE}, and the first that works is taken"
    if backend == "osmesa":
        advice += f", or unset {_SWITCH}"
    return TaskError(f"pictures need a graphics library, and {backend} does not work ({reason}); {advice}")


@contextlib.contextmanager
def _environment(**values: str) -> Iterator[None]:
    """With these variables; afterwards all are as before, also PYOPENGL_PLATFORM, which mujoco's modules set."""
    kept = {name: os.environ.get(name) for name in (_PLATFORM, *values)}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in kept.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value


def _open_second_display(backend: str, module: Any) -> None:
    """Open a display whose threads run in this forked process: the inherited one waits for its parent's for ever.

    Only Mesa has a second one. It ends the process by a signal unless os._exit does, as multiprocessing's processes.
    """
    egl: Any = getattr(module, "EGL", None)
    displays = [getattr(sys.modules.get(name), "EGL_DISPLAY", None) for name in _EGL_DISPLAYS]
    vendors = {egl.eglQueryString(display, egl.EGL_VENDOR) for display in displays if egl and display}
    if vendors != {b"Mesa Project"} or _SECOND_DISPLAY in _inherited or multiprocessing.parent_process() is None:
        raise TaskError(
            f"{backend} renders no pictures in this process, forked from one that has rendered; start it by spawn, as "
            'gymnasium.make_vec does with vector_kwargs={"context": "spawn"}, or let only the forked processes render'
        )
    with _environment(LIBGL_ALWAYS_SOFTWARE="true"):  # one of the graphics card would share the parent's connection
        module.EGL_DISPLAY = egl.eglGetPlatformDisplayEXT(_SURFACELESS, None, None)
        egl.eglInitialize(module.EGL_DISPLAY, None, None)
    _opened.add(_SECOND_DISPLAY)


def _unload_pyopengl(loaded: set[str]) -> None:
    """Let PyOpenGL be imported anew, since it keeps the platform of its first import, unless it was `loaded` before."""
    for name in {*sys.modules} - loaded:
        if name.split(".")[0] == "OpenGL" or name.startswith(("mujoco.egl", "mujoco.osmesa")):
            del sys.modules[name]
