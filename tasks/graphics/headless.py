"""Imports mujoco and dm_control where there is no screen and perhaps no graphics library.

Both load a graphics library at import: mujoco fails where MUJOCO_GL names a missing one, dm_control tries a screen
first and warns. Training renders nothing, and rendering.py loads its own library. So dm_control is always imported
without graphics, and mujoco where it fails with them. mujoco.Renderer still follows MUJOCO_GL.
"""

import contextlib
import os
from collections.abc import Iterator


@contextlib.contextmanager
def _no_graphics() -> Iterator[None]:
    backend = os.environ.get("MUJOCO_GL")
    os.environ["MUJOCO_GL"] = "disable"
    try:
        yield
    finally:
        del os.environ["MUJOCO_GL"]
        if backend is not None:
            os.environ["MUJOCO_GL"] = backend


try:
    import mujoco
except (ImportError, AttributeError, RuntimeError):  # what PyOpenGL raises for a missing library
    with _no_graphics():
        import mujoco

with _no_graphics():
    import dm_control.mujoco

__all__ = ["dm_control", "mujoco"]
