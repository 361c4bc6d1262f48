"""Imports mujoco and dm_control where there is no screen and perhaps no graphics library.

Both load a graphics library at import: mujoco fails where MUJOCO_GL names a missing one, dm_control tries a screen
first and warns. Training renders nothing, and rendering.py loads its own library. So dm_control's `_render` is
imported when it is first used, and finds what it would have found; mujoco is imported without graphics where it fails
with them.
"""

import importlib
import os
import sys
from types import ModuleType
from typing import Any

_RENDER = "dm_control._render"


class _RenderWhenUsed(ModuleType):
    """Stands for dm_control's `_render` in the one module that dm_control.mujoco imports it into."""

    def __getattr__(self, name: str) -> Any:
        return getattr(importlib.import_module(_RENDER), name)


try:
    import mujoco
except (ImportError, AttributeError, RuntimeError):  # what PyOpenGL raises for a missing library
    if "MUJOCO_GL" not in os.environ:
        raise
    backend = os.environ["MUJOCO_GL"]
    os.environ["MUJOCO_GL"] = "disable"
    try:
        import mujoco
    finally:
        os.environ["MUJOCO_GL"] = backend

if _RENDER in sys.modules:
    import dm_control.mujoco
else:
    sys.modules[_RENDER] = _RenderWhenUsed(_RENDER)
    try:
        import dm_control.mujoco
    finally:
        del sys.modules[_RENDER]

__all__ = ["dm_control", "mujoco"]
