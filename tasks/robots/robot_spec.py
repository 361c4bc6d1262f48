"""A robot's MJCF file: its root, its two wheels, the frame between them, and where its laser belongs."""

import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np

from tasks.errors import TaskError
from tasks.physics import FloatArray
from tasks.robots.drive import find_actuator, wheel_contact
from tasks.robots.names import RobotFile
from tasks.room_geometry.geom_shapes import reach
from tasks.scene.loading import compile_spec, read_spec

LASER_GAP = 0.02  # m from the highest part of a robot that names no laser to its beams
_UP = np.array([0.0, 0.0, 1.0])
_SIDES = {side: re.compile(rf"{side}|(^|[^a-z]){side[0]}([^a-z]|$)") for side in ("left", "right")}
_LASER = re.compile(r"laser|lidar|lds|scan")
_PARALLEL = 0.99  # cosine of the angle from which on two axes count as parallel


class RobotSpec(NamedTuple):
    """A robot, not yet compiled.

    Attributes:
        spec: its file.
        root: the body that holds all of it.
        wheels: names of the joints of the left and the right wheel.
        root_position: of the root in the base's frame, which lies on the floor midway between the wheels, x ahead, y to
            the left and z up: (3,), metres.
        root_rotation: of the root in the base's frame, (3, 3).
        laser_body: whose own parts the beams do not see; empty for the base.
        laser_position: of the beams in the frame of that body, (3,), metres.
        laser_place: of the beams in the base's frame, (3,), metres.
        size: of the larger of height and width, metres.
    """

    spec: mujoco.MjSpec
    root: mujoco.MjsBody
    wheels: tuple[str, str]
    root_position: FloatArray
    root_rotation: FloatArray
    laser_body: str
    laser_position: FloatArray
    laser_place: FloatArray
    size: float


def read_robot(file: RobotFile) -> RobotSpec:
    """Read a robot's file.

    Raises:
        TaskError: MuJoCo cannot read it, it has no two driven wheels, or its laser is tilted.
    """
    name = f"the robot {file.path}"
    spec = read_spec(file.path, "robot")
    _name_bodies(spec)
    model = compile_spec(spec, name)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    joints = _named_wheels(model, file.wheels, name) if file.wheels else _find_wheels(model, name)
    _check_servos(model, joints, name)
    root = _find_root(model, joints, name)
    try:
        contacts = [wheel_contact(model, data, joint) for joint in joints]
    except ValueError as error:
        raise TaskError(f"{name} cannot drive: {error}") from error
    rotation = _base_rotation(data, joints, contacts, name)
    position = np.mean(contacts, axis=0)
    geoms = [geom for geom in range(model.ngeom) if model.body_rootid[model.geom_bodyid[geom]] == root]
    top = max(reach(model, data, geom, _UP) for geom in geoms) - position[2]
    width = max(abs(reach(model, data, geom, side * rotation[:, 0])) for geom in geoms for side in (1, -1))
    body, place = _find_laser(spec, model, data, root)
    axes = np.eye(3) if body is None else data.xmat[body].reshape(3, 3)
    if body is None:
        here = place = np.array([0.0, 0.0, top + LASER_GAP])
    else:
        here, place = (place - data.xpos[body]) @ axes, (place - position) @ rotation
        if np.min(np.sum(axes * rotation, axis=0)) < _PARALLEL:
            raise TaskError(f"{name} has a laser on the turned body {model.body(body).name!r}; x must lead ahead, z up")
    return RobotSpec(
        spec=spec,
        root=spec.body(model.body(root).name),
        wheels=(model.joint(joints[0]).name, model.joint(joints[1]).name),
        root_position=(data.xpos[root] - position) @ rotation,
        root_rotation=rotation.T @ data.xmat[root].reshape(3, 3),
        laser_body="" if body is None else model.body(body).name,
        laser_position=here,
        laser_place=place,
        size=float(max(top, width)),
    )


def _name_bodies(spec: mujoco.MjSpec) -> None:
    """Name bodies without a name: they are found by it."""
    taken = {body.name for body in spec.bodies}
    for number, body in enumerate(spec.bodies):
        if not body.name:
            body.name = f"body_{number}" if f"body_{number}" not in taken else f"unnamed_body_{number}"


# Wheels ---------------------------------------------------------------------------------------------------------------


def _driven_joints(model: mujoco.MjModel) -> list[int]:
    hinges = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE)
    return [int(joint) for joint in hinges if find_actuator(model, int(joint)) is not None]


def _named_wheels(model: mujoco.MjModel, names: Sequence[str], name: str) -> list[int]:
    driven = _driven_joints(model)
    by_name = {model.actuator(find_actuator(model, joint)).name: joint for joint in driven}
    by_name |= {model.joint(joint).name: joint for joint in driven}
    for wheel in names:
        if wheel not in by_name:
            raise TaskError(f"{name} has no wheel {wheel!r}; it drives the joints {_names(model, driven)}")
    if names[0] == names[1]:
        raise TaskError(f"{name} needs two wheels, not {names[0]!r} twice")
    return [by_name[wheel] for wheel in names]


def _find_wheels(model: mujoco.MjModel, name: str) -> list[int]:
    """The driven joints that names call left and right, or, of two alone, those at the left and at the right."""
    driven = _driven_joints(model)
    if len(driven) < 2:
        found = f"it drives {_names(model, driven)} alone" if driven else "it drives no hinge joint"
        raise TaskError(f"{name} has no two wheels, which are hinge joints with a velocity actuator each: {found}")
    for candidates in (driven, [joint for joint in driven if "wheel" in _words(model, joint)]):
        sides = [[joint for joint in candidates if side.search(_words(model, joint))] for side in _SIDES.values()]
        if [len(side) for side in sides] == [1, 1] and sides[0] != sides[1]:
            return [sides[0][0], sides[1][0]]
    if len(driven) == 2:
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        apart = data.xanchor[driven[0]] - data.xanchor[driven[1]]
        if abs(apart[1]) > abs(apart[0]):
            return driven if apart[1] > 0.0 else driven[::-1]
    raise TaskError(
        f"{name} does not say which of its joints {_names(model, driven)} are its two wheels; "
        "<file>@<left joint>,<right joint> does"
    )


def _words(model: mujoco.MjModel, joint: int) -> str:
    actuator = find_actuator(model, joint)
    names = (model.joint(joint).name, model.body(model.jnt_bodyid[joint]).name, model.actuator(actuator).name)
    return " ".join(names).lower()


def _names(model: mujoco.MjModel, joints: Sequence[int]) -> str:
    return ", ".join(str(model.joint(joint).name) for joint in joints) or "none"


def _check_servos(model: mujoco.MjModel, joints: Sequence[int], name: str) -> None:
    for joint in joints:
        actuator = find_actuator(model, joint)
        if not (model.actuator_gainprm[actuator][0] and model.actuator_biasprm[actuator][2]):
            wheel = model.joint(joint).name
            servo = f'<velocity joint="{wheel}" kv="…"/>'
            raise TaskError(f"{name} drives its wheel {wheel!r} by an actuator that keeps no speed: {servo} does")


def _find_root(model: mujoco.MjModel, joints: Sequence[int], name: str) -> int:
    bodies = [int(model.jnt_bodyid[joint]) for joint in joints]
    roots = {int(model.body_rootid[body]) for body in bodies}
    if len(roots) != 1 or roots & set(bodies):
        raise TaskError(f"{name} has wheels that hang on no common body")
    (root,) = roots
    kinds = [int(model.jnt_type[joint]) for joint in range(model.njnt) if model.jnt_bodyid[joint] == root]
    if kinds not in ([], [int(mujoco.mjtJoint.mjJNT_FREE)]):
        moved = f"the body {model.body(root).name!r} has joints of its own"
        raise TaskError(f"{name} must move by its wheels alone, with a free joint or none: {moved}")
    return root


def _base_rotation(data: mujoco.MjData, joints: Sequence[int], contacts: Sequence[FloatArray], name: str) -> FloatArray:
    """Axes of the base as columns, (3, 3)."""
    across = np.append((contacts[0] - contacts[1])[:2], 0.0)
    length = float(np.linalg.norm(across))
    left = across / length if length else across
    for joint in joints:
        if abs(float(data.xaxis[joint] @ left)) < _PARALLEL:
            axis = " ".join(f"{value:.2g}" for value in data.xaxis[joint])
            raise TaskError(f"{name} has a wheel that turns about ({axis}), not about the line to the other wheel")
    return np.stack([np.cross(left, _UP), left, _UP], axis=1)


# Laser ----------------------------------------------------------------------------------------------------------------


def _find_laser(
    spec: mujoco.MjSpec, model: mujoco.MjModel, data: mujoco.MjData, root: int
) -> tuple[int | None, FloatArray]:
    """The body that carries the laser, and its place in the file, (3,) metres; None where no part has such a name.

    The ring of a file counts, then a site and then a body that is called laser, lidar, lds or scan.
    """
    rings = [sensor.objname for sensor in spec.sensors if sensor.name.startswith("range_")]
    sites = [site for site in range(model.nsite) if _is_of(model, int(model.site_bodyid[site]), root)]
    bodies = [body for body in range(model.nbody) if _is_of(model, body, root)]
    for site in [each for each in sites if model.site(each).name in rings] + _alike(sites, model.site):
        return int(model.site_bodyid[site]), data.site_xpos[site].copy()
    for body in _alike(bodies, model.body):
        return body, data.xpos[body].copy()
    return None, np.zeros(3)


def _is_of(model: mujoco.MjModel, body: int, root: int) -> bool:
    return bool(model.body_rootid[body] == root)


def _alike(numbers: Sequence[int], element: Callable[[int], Any]) -> list[int]:
    """Those with the name of a laser; one that is called laser comes first."""
    named = [number for number in numbers if _LASER.search(element(number).name.lower())]
    return sorted(named, key=lambda number: element(number).name != "laser")
