"""Offscreen pictures of a scene, by the graphics library that gl_context.py finds.

The library is loaded with the first renderer: training that renders nothing needs none. Keep one renderer, in one
thread: it fails in another thread, and a process forked after a first picture hangs when it renders.
"""

import atexit
import functools
import os
import weakref
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from tasks.errors import TaskError
from tasks.graphics.gl_context import missing_graphics_error, open_context

Picture = npt.NDArray[np.uint8]

FREE = "free"


class OffscreenRenderer:
    """One graphics context and one scene, kept from picture to picture; for use from one thread."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int, smooth: bool = True) -> None:
        """Open a context for pictures.

        Args:
            model: of the scene.
            width: px.
            height: px.
            smooth: whether edges are smoothed as the model asks; without, software renders in less than half the time.

        Raises:
            TaskError: no working graphics library, or a size beyond the model's offscreen buffer.
        """
        check_picture(model, FREE, width, height)
        self._model = model
        self._rect = mujoco.MjrRect(0, 0, width, height)
        self._context: Any = open_context(width, height)
        self._scene = mujoco.MjvScene(model, maxgeom=2000)
        self._options = mujoco.MjvOption()
        self._options.flags[mujoco.mjtVisFlag.mjVIS_RANGEFINDER] = 0
        quality = model.vis.quality
        samples = quality.offsamples
        try:
            quality.offsamples = samples if smooth else 0
            self._mjr = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        except mujoco.FatalError as error:  # OpenGL without the functions that MuJoCo needs
            raise missing_graphics_error(os.environ.get("MUJOCO_GL", "").strip().lower() or "egl", error) from error
        finally:
            quality.offsamples = samples  # the scene's hash covers it
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._mjr)
        # Registered after the library's own exit handler and so run before it: a context freed later raises.
        self._at_exit = functools.partial(_close_if_alive, weakref.ref(self))
        atexit.register(self._at_exit)

    def render(
        self,
        data: mujoco.MjData,
        camera: str | int | mujoco.MjvCamera,
        decorate: Callable[[mujoco.MjvScene], None] | None = None,
    ) -> Picture:
        """The scene as a camera sees it.

        Args:
            data: state of the scene.
            camera: name or number of a camera, `free` or −1 for the model's overall view, or a camera object.
            decorate: adds geoms that the model does not have.

        Returns:
            uint8 (height, width, 3), first row on top.
        """
        view = camera if isinstance(camera, mujoco.MjvCamera) else _find_view(self._model, camera)
        self._context.make_current()
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(self._model, data, self._options, None, view, everything, self._scene)
        if decorate is not None:
            decorate(self._scene)
        mujoco.mjr_render(self._rect, self._scene, self._mjr)
        picture = np.empty((self._rect.height, self._rect.width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(picture, None, self._rect, self._mjr)
        return picture[::-1].copy()

    def close(self) -> None:
        """Free the context; may be called again."""
        if self._context is not None:
            self._context.make_current()
            self._mjr.free()
            self._context.free()
            self._context = None
            atexit.unregister(self._at_exit)


def check_picture(model: mujoco.MjModel, camera: str | int, width: int, height: int) -> None:
    """TaskError where a scene has no such camera, or its offscreen buffer no such size, px."""
    limits = model.vis.global_
    if not (0 < width <= limits.offwidth and 0 < height <= limits.offheight):
        raise TaskError(f"a picture must be within {limits.offwidth} x {limits.offheight} px, not {width} x {height}")
    _find_view(model, camera)


def _find_view(model: mujoco.MjModel, camera: str | int) -> mujoco.MjvCamera:
    names = [model.camera(index).name for index in range(model.ncam)]
    view = mujoco.MjvCamera()
    if camera in (FREE, -1):
        mujoco.mjv_defaultFreeCamera(model, view)
        view.distance *= 0.8  # MuJoCo leaves a wide margin
    elif camera in names or camera in range(len(names)):
        view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        view.fixedcamid = names.index(camera) if isinstance(camera, str) else camera
    else:
        raise TaskError(f"there is no camera {camera!r}; there are {', '.join([*names, FREE])}")
    return view


def _close_if_alive(reference: "weakref.ref[OffscreenRenderer]") -> None:
    renderer = reference()
    if renderer is not None:
        renderer.close()
