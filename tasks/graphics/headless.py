"""Imports mujoco and dm_control where there is no screen and perhaps no graphics library.

Both look for one at import. mujoco fails where MUJOCO_GL names one that is missing, dm_control tries a screen first and
warns. Pictures of the tasks have their own loader (rendering.py) and training draws none, so mujoco is imported without
graphics where it fails with them, and dm_control always. mujoco.Renderer goes on working as MUJOCO_GL has it.
"""

import contextlib
import os
from collections.abc import Iterator


@contextlib.contextmanager
def _no_graphics() -> Iterator[None]:
    asked_for = os.environ.get("MUJOCO_GL")
    os.environ["MUJOCO_GL"] = "disable"
    try:
        yield
    finally:
        del os.environ["MUJOCO_GL"]
        if asked_for is not None:
            os.environ["MUJOCO_GL"] = asked_for


try:
    import mujoco
except (ImportError, AttributeError, RuntimeError):  # what PyOpenGL raises for a missing library
    with _no_graphics():
        import mujoco

with _no_graphics():
    import dm_control.mujoco

__all__ = ["dm_control", "mujoco"]
