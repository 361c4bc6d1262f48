"""MuJoCo's viewer in real time, checked for a screen and closed cleanly."""

import contextlib
import importlib
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import mujoco

from asddpg.errors import UserError

LATE = 0.5  # s; a longer delay of the simulation is skipped, a shorter one caught up
CLOSING = 5.0  # s that the viewer's own thread gets to end


@contextlib.contextmanager
def open_viewer(model: mujoco.MjModel, data: mujoco.MjData, on_key: Callable[[int], None]) -> Iterator[Any]:
    """The passive viewer, with the whole scene in view and the body `base`, where there is one, in the middle.

    Args:
        model: the scene.
        data: its state, shown at each sync().
        on_key: called with GLFW's code of each key, by the viewer's thread.

    Raises:
        UserError: there is no screen with OpenGL.
    """
    check_screen()
    viewer = importlib.import_module("mujoco.viewer")  # only now: it looks for GLFW's library at import
    before = set(threading.enumerate())
    opened = viewer.launch_passive(model, data, key_callback=on_key, show_left_ui=False, show_right_ui=False)
    threads = set(threading.enumerate()) - before
    try:
        with opened.lock():
            _look_at(model, opened.cam)
        yield opened
    finally:
        opened.close()
        # The program's end frees GLFW, which the viewer's thread may still be drawing with.
        for thread in threads:
            thread.join(CLOSING)


def wait_for_frames(frame: float) -> Iterator[int]:
    """Wait until a frame of `frame` seconds is due; yields how many are, however long a picture takes.

    At most LATE seconds of them.
    """
    due_at = time.monotonic()
    while True:
        time.sleep(max(0.0, due_at - time.monotonic()))
        due = 1 + max(0, int((time.monotonic() - due_at) / frame))
        due_at += due * frame
        yield min(due, max(1, int(LATE / frame)))


def _look_at(model: mujoco.MjModel, camera: mujoco.MjvCamera) -> None:
    mujoco.mjv_defaultFreeCamera(model, camera)
    camera.distance *= 0.8
    base = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "base")
    if base >= 0:
        camera.type = mujoco.mjtCamera.mjCAMERA_TRACKING
        camera.trackbodyid = base


def check_screen() -> None:
    """UserError where no window can be opened; the viewer itself would hang."""
    try:
        glfw = importlib.import_module("glfw")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            opens = bool(glfw.init()) and _opens_window(glfw)
            glfw.terminate()
    except (ImportError, AttributeError, OSError):
        opens = False
    if not opens:
        raise UserError(
            "the viewer needs a screen with OpenGL and there is none here: run it on a desktop, over ssh with X "
            "forwarding (ssh -Y), or on a virtual screen (xvfb-run); python -m tools.picture draws without one"
        )


def _opens_window(glfw: Any) -> bool:
    glfw.window_hint(glfw.VISIBLE, 0)
    window = glfw.create_window(64, 64, "probe", None, None)
    if window:
        glfw.destroy_window(window)
    return bool(window)
