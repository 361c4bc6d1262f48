"""Imports mujoco and dm_control without letting them look for a graphics library.

Both load one at import: with MUJOCO_GL set to a library that is missing the import fails, with none set dm_control
tries a screen first and warns. Pictures have their own loader here (rendering.py), so this module, imported before any
other of the package, hides the variable for the moment of the import.
"""

import os

_asked_for = os.environ.pop("MUJOCO_GL", None)
os.environ["MUJOCO_GL"] = "disable"
try:
    import dm_control.mujoco
    import mujoco
finally:
    del os.environ["MUJOCO_GL"]
    if _asked_for is not None:
        os.environ["MUJOCO_GL"] = _asked_for

__all__ = ["dm_control", "mujoco"]
