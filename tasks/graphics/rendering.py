"""Offscreen pictures of a scene, by the graphics library that gl_context.py finds.

The library is loaded with the first renderer: training that renders nothing needs none. Keep one renderer for many
pictures.
"""

import weakref
from collections.abc import Callable
from functools import partial

import mujoco
import numpy as np
import numpy.typing as npt

from tasks.errors import TaskError
from tasks.graphics.gl_context import open_context
from tasks.graphics.render_thread import RenderThread, render_thread

Picture = npt.NDArray[np.uint8]

FREE = "free"


class _Drawing:
    """A graphics context, and what MuJoCo keeps in it; made, used and freed in the render thread."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int, smooth: bool) -> None:
        def make_context() -> mujoco.MjrContext:
            quality = model.vis.quality
            samples = quality.offsamples
            try:
                quality.offsamples = samples if smooth else 0
                return mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
            finally:
                quality.offsamples = samples  # the scene's hash covers it

        self._context, self._mjr = open_context(width, height, make_context)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._mjr)

    def draw(self, scene: mujoco.MjvScene, rect: mujoco.MjrRect) -> Picture:
        self._context.make_current()
        mujoco.mjr_render(rect, scene, self._mjr)
        picture = np.empty((rect.height, rect.width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(picture, None, rect, self._mjr)
        return picture[::-1].copy()

    def free(self) -> None:
        self._context.make_current()
        self._mjr.free()
        self._context.free()


class OffscreenRenderer:
    """One graphics context and one scene, kept from picture to picture; for use from any thread.

    In a forked process, and after close(), the next picture opens another context.
    """

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
        self._model, self._smooth = model, smooth
        self._rect = mujoco.MjrRect(0, 0, width, height)
        self._scene = mujoco.MjvScene(model, maxgeom=2000)
        self._options = mujoco.MjvOption()
        self._options.flags[mujoco.mjtVisFlag.mjVIS_RANGEFINDER] = 0
        self._thread: RenderThread | None = None
        self._drawing: _Drawing | None = None
        thread = render_thread()
        thread.call(lambda: self._open(thread))

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
        thread = render_thread()

        def draw() -> Picture:
            everything = mujoco.mjtCatBit.mjCAT_ALL
            mujoco.mjv_updateScene(self._model, data, self._options, None, view, everything, self._scene)
            if decorate is not None:
                decorate(self._scene)
            return self._open(thread).draw(self._scene, self._rect)

        return thread.call(draw)

    def _open(self, thread: RenderThread) -> _Drawing:
        if self._drawing is None or self._thread is not thread:
            self._thread = thread
            self._drawing = _Drawing(self._model, self._rect.width, self._rect.height, self._smooth)
            thread.kept.append(self._drawing)
            self._free = weakref.finalize(self, thread.post, partial(_free, thread, self._drawing))
            self._free.atexit = False
        return self._drawing

    def close(self) -> None:
        """Free the context; may be called again."""
        self._free()
        self._drawing = None


def _free(thread: RenderThread, drawing: _Drawing) -> None:
    thread.kept.remove(drawing)
    drawing.free()


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
