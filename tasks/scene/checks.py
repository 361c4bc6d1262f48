"""Faults of a compiled scene: invalid numbers, and missing elements that every scene with the robot must have."""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from tasks.robots.drive import names_wheels

MAX_TIMESTEP = 0.02  # s; beyond it contacts of a robot of this size are no longer realistic

# Element → fields that must be finite. A body's elements come before the body, whose mass follows from them.
_FINITE = {
    "geom": ("pos", "size", "quat", "friction", "rgba"),
    "site": ("pos", "size", "quat"),
    "joint": ("pos", "axis", "range"),
    "camera": ("pos", "quat", "fovy"),
    "light": ("pos", "dir"),
    "body": ("pos", "quat", "mass", "ipos", "inertia"),
    "actuator": ("gear", "ctrlrange", "forcerange", "gainprm", "biasprm"),
    "sensor": ("cutoff", "noise"),
}
_PREFIXES = {"joint": "jnt", "camera": "cam"}
_WHEELS = ("left_wheel", "right_wheel")
_BEAMS = "rangefinder sensors range_00, range_01, …"


def find_invalid_number(model: mujoco.MjModel) -> str | None:
    """The first number of a model that is NaN, infinite or out of range, as half a sentence; None where there is none.

    MuJoCo compiles a time step of 0 and NaN positions without an error.
    """
    if not 0 < model.opt.timestep <= MAX_TIMESTEP:
        return (
            f"has the timestep {model.opt.timestep:g} in its option element, but it must be above 0 s and at most "
            f"{MAX_TIMESTEP:g} s"
        )
    if not np.all(np.isfinite(model.opt.gravity)):
        return f"has the gravity {_numbers(model.opt.gravity)} in its option element, but it must be finite"
    for kind, fields in _FINITE.items():
        for field in fields:
            values = np.asarray(getattr(model, f"{_PREFIXES.get(kind, kind)}_{field}"))
            rows = values[:, np.newaxis] if values.ndim == 1 else values
            faulty = np.flatnonzero(~np.isfinite(rows).all(axis=1))
            if len(faulty):
                where = f"{kind} {_name(model, kind, int(faulty[0]))}"
                return f"has the {where} with {field} {_numbers(rows[faulty[0]])}, but it must be finite"
    for field in ("damping", "armature", "frictionloss"):  # kept by degree of freedom
        faulty = np.flatnonzero(~np.isfinite(getattr(model, f"dof_{field}")))
        if len(faulty):
            joint = _name(model, "joint", int(model.dof_jntid[faulty[0]]))
            return f"has the joint {joint} with a {field} that is not finite, but it must be finite"
    return None


def find_missing_elements(model: mujoco.MjModel, cameras: Sequence[str] = ()) -> list[str]:
    """Descriptions of the elements that a scene with the robot must have and this one lacks.

    Args:
        model: the compiled scene.
        cameras: names of the cameras it must have.
    """
    joint, goal = _find(model, "joint", "base"), _find(model, "body", "goal")
    is_free = joint and joint.type[0] == mujoco.mjtJoint.mjJNT_FREE and model.body(joint.bodyid[0]).name == "base"
    rangefinders = np.flatnonzero(model.sensor_type == mujoco.mjtSensor.mjSENS_RANGEFINDER)
    found = {
        "body 'base'": _find(model, "body", "base"),
        "free joint 'base' of the body 'base'": is_free,
        **(_find_wheels(model) if not names_wheels(model) else {}),
        _BEAMS: any(model.sensor(index).name.startswith("range_") for index in rangefinders),
        "mocap body 'goal'": goal and goal.mocapid[0] >= 0,
        "geom 'floor'": _find(model, "geom", "floor"),
        **{f"camera {name!r}": _find(model, "camera", name) for name in cameras},
    }
    return [element for element, is_present in found.items() if not is_present]


def _find_wheels(model: mujoco.MjModel) -> dict[str, Any]:
    joints, actuators = ({name: _find(model, kind, name) for name in _WHEELS} for kind in ("joint", "actuator"))
    return {f"joint {name!r}": joint for name, joint in joints.items()} | {
        f"actuator {name!r}": actuator for name, actuator in actuators.items()
    }


def _find(model: mujoco.MjModel, kind: str, name: str) -> Any:
    """The named element; None where there is none."""
    try:
        return getattr(model, kind)(name)
    except KeyError:
        return None


def _name(model: mujoco.MjModel, kind: str, row: int) -> str:
    name = str(getattr(model, _PREFIXES.get(kind, kind))(row).name)
    return repr(name) if name else f"number {row}"


def _numbers(values: Sequence[float]) -> str:
    return " ".join(f"{value:g}" for value in values)
