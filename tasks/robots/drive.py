"""The two driven wheels of a compiled robot: what they are, what they can, and what a command of theirs is."""

from typing import NamedTuple, Self

import mujoco
import numpy as np

from tasks.constants import MAX_ANGULAR_VELOCITY, MAX_LINEAR_VELOCITY, TURN_RATE_LIMIT
from tasks.room_geometry.geom_shapes import FloatArray, reach

SIDES = ("left", "right")
DRIVE = "drive"  # the tuple of a scene that names the joints of the left and the right wheel, where it has one
LIMITS = ("max_linear_velocity", "max_angular_velocity")  # numerics of a robot that states them, m/s and rad/s
_DOWN = np.array([0.0, 0.0, -1.0])


class Wheel(NamedTuple):
    """A driven wheel.

    Attributes:
        joint: number of its joint.
        actuator: number of its actuator.
        direction: 1.0 where a positive angle rolls the robot forward, −1.0 where it rolls it back.
        gain: control of the actuator for a speed of the wheel forward, 1/(rad/s).
        speed_limit: rad/s; infinite where the control is not limited.
    """

    joint: int
    actuator: int
    direction: float
    gain: float
    speed_limit: float


class Drive(NamedTuple):
    """Wheels and limits of a robot.

    Attributes:
        wheels: the left one and the right one.
        radius: of the wheels, metres.
        track: between their contact points, metres.
        max_linear_velocity: m/s, by the robot's own statement or by its wheels; infinite where neither limits it.
        max_angular_velocity: rad/s, likewise.
        task_limits: largest v and ω of a task that gives none: those that the robot states, else the paper's or less.
    """

    wheels: tuple[Wheel, Wheel]
    radius: float
    track: float
    max_linear_velocity: float
    max_angular_velocity: float
    task_limits: tuple[float, float]

    @classmethod
    def from_model(cls, model: mujoco.MjModel) -> Self:
        """Of the robot of a compiled scene, at rest with the frame of `base` on the world's."""
        data = mujoco.MjData(model)
        start = int(model.joint("base").qposadr[0])
        data.qpos[start : start + 7] = [0, 0, 0, 1, 0, 0, 0]
        mujoco.mj_kinematics(model, data)
        joints = wheel_joints(model)
        left, right = (_read_wheel(model, data, joint) for joint in joints)
        contacts = [wheel_contact(model, data, joint) for joint in joints]
        radius = float(np.mean([data.xanchor[joint][2] - at[2] for joint, at in zip(joints, contacts, strict=True)]))
        track = float(contacts[0][1] - contacts[1][1])
        speed = min(left.speed_limit, right.speed_limit) * radius
        stated = [_number(model, name) for name in LIMITS]
        # The Pioneer's firmware cuts its turn rate; of a robot that brings its own tuple nothing of the kind is known.
        turn = 2.0 * speed / track if names_wheels(model) else TURN_RATE_LIMIT
        v, omega = (min(most, by_wheels) for most, by_wheels in zip(stated, (speed, turn), strict=True))
        usual = (
            most if np.isfinite(most) else paper
            for most, paper in zip(stated, (MAX_LINEAR_VELOCITY, MAX_ANGULAR_VELOCITY), strict=True)
        )
        chosen = tuple(min(value, most) for value, most in zip(usual, (v, omega), strict=True))
        return cls((left, right), radius, track, v, omega, (chosen[0], chosen[1]))


def wheel_joints(model: mujoco.MjModel) -> list[int]:
    """Numbers of the joints of the left and the right wheel: those of the tuple `drive`, else those of that name.

    Raises:
        KeyError: there is no such joint.
    """
    if not names_wheels(model):
        return [int(model.joint(f"{side}_wheel").id) for side in SIDES]
    first = int(model.tuple_adr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TUPLE, DRIVE)])
    return [int(joint) for joint in model.tuple_objid[first : first + 2]]


def names_wheels(model: mujoco.MjModel) -> bool:
    """Whether a scene has the tuple `drive`."""
    return bool(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TUPLE, DRIVE) >= 0)


def find_actuator(model: mujoco.MjModel, joint: int) -> int | None:
    """Number of the actuator that turns a joint; None where none does."""
    is_of_joint = (np.asarray(model.actuator_trntype) == mujoco.mjtTrn.mjTRN_JOINT) & (
        np.asarray(model.actuator_trnid)[:, 0] == joint
    )
    found = np.flatnonzero(is_of_joint)
    return int(found[0]) if len(found) else None


def wheel_contact(model: mujoco.MjModel, data: mujoco.MjData, joint: int) -> FloatArray:
    """Where a wheel touches the floor: under its lowest colliding geom's middle, (3,) metres, world frame.

    Raises:
        ValueError: no geom of the wheel collides.
    """
    geoms = [
        geom
        for geom in range(model.ngeom)
        if _is_below(model, int(model.geom_bodyid[geom]), int(model.jnt_bodyid[joint]))
        and (model.geom_contype[geom] or model.geom_conaffinity[geom])
    ]
    if not geoms:
        raise ValueError(f"the wheel of joint {model.joint(joint).name!r} has no geom that touches anything")
    lowest = max(geoms, key=lambda geom: reach(model, data, geom, _DOWN))
    x, y, _ = data.geom_xpos[lowest]
    return np.array([x, y, -reach(model, data, lowest, _DOWN)])


def _is_below(model: mujoco.MjModel, body: int, ancestor: int) -> bool:
    while body > ancestor:
        body = int(model.body_parentid[body])
    return body == ancestor


def _read_wheel(model: mujoco.MjModel, data: mujoco.MjData, joint: int) -> Wheel:
    actuator = find_actuator(model, joint)
    assert actuator is not None
    direction = 1.0 if data.xaxis[joint][1] >= 0.0 else -1.0
    gear, servo = float(model.actuator_gear[actuator][0]), float(model.actuator_gainprm[actuator][0])
    damping = -float(model.actuator_biasprm[actuator][2])
    # A velocity servo is at rest where servo · control = damping · gear · speed; of a motor nothing of the kind holds.
    ratio = damping / servo if servo and damping else 1.0
    gain = direction * gear * ratio
    is_limited = bool(model.actuator_ctrllimited[actuator]) and gain != 0.0
    limit = float(model.actuator_ctrlrange[actuator][1]) / abs(gain) if is_limited else np.inf
    return Wheel(joint, actuator, direction, gain, limit)


def _number(model: mujoco.MjModel, name: str) -> float:
    """A positive number that a robot states; infinite where it does not."""
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, name)
    value = float(model.numeric_data[model.numeric_adr[number]]) if number >= 0 else np.inf
    return value if value > 0.0 else np.inf
