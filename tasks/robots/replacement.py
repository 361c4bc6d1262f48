"""Puts a robot into a scene that has the Pioneer, in its place."""

import mujoco
import numpy as np

from tasks.laser import BeamRing, set_beams
from tasks.robots.drive import DRIVE, LIMITS
from tasks.robots.names import PIONEER, find_robot
from tasks.robots.robot_spec import RobotSpec, read_robot

PREFIX = "robot_"  # of every name of a robot but those of its sensors: a room's names are its own
_CHASE = np.array([-2.2, 0.0, 1.6])  # m, as the Pioneer's camera of that name, whose size is 0.3 m
_PORTRAIT = np.array([0.95, -0.8, 0.62])  # m, likewise
_CHASE_SIZE, _LEAST_SCALE, _MOST_SCALE = 0.3, 0.4, 3.0
_ONBOARD_HEIGHT = 0.03  # m above the laser


def replace_robot(spec: mujoco.MjSpec, name: str) -> None:
    """Put a robot in the place of a scene's Pioneer; the Pioneer itself changes nothing.

    Its base becomes the body `base`, with the free joint of that name, the cameras `chase`, `onboard` and `portrait`,
    and the ring of BeamRing() where its own laser is, or above its highest part. The tuple `drive` names the wheels'
    joints.

    Args:
        spec: a scene not yet compiled; changed in place.
        name: of the robot.

    Raises:
        TaskError: there is no such robot, or its file holds none.
    """
    if name == PIONEER:
        return
    robot = read_robot(find_robot(name))
    home = spec.body("base").pos.copy()
    reading = next(each.intprm.copy() for each in spec.sensors if each.name.startswith("range_"))
    spec.delete(spec.body("base"))
    used = {geom.meshname for geom in spec.geoms}
    for mesh in [each for each in spec.meshes if each.name not in used]:
        spec.delete(mesh)
    base = spec.worldbody.add_body(name="base", pos=home)
    base.add_freejoint(name="base")
    stated = {each.name: float(each.data[0]) for each in robot.spec.numerics if each.name in LIMITS}
    _attach(spec, base, robot)
    for limit, value in stated.items():
        spec.add_numeric(name=limit, data=[value], size=1)
    joint = mujoco.mjtObj.mjOBJ_JOINT
    wheels = [f"{PREFIX}{wheel}" for wheel in robot.wheels]
    spec.add_tuple(name=DRIVE, objtype=[joint, joint], objname=wheels, objprm=[0.0, 0.0])
    _add_cameras(base, robot)
    base.add_body(name="laser", pos=robot.laser_place)  # the frame of the scans
    carrier = spec.body(f"{PREFIX}{robot.laser_body}") if robot.laser_body else base
    carrier.add_site(name="ray_0", pos=robot.laser_position, group=4, size=[0.002] * 3, rgba=[1.0, 0.9, 0.0, 0.2])
    spec.add_sensor(
        name="range_0",
        type=mujoco.mjtSensor.mjSENS_RANGEFINDER,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname="ray_0",
        intprm=reading,
    )
    set_beams(spec, BeamRing())


def _attach(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: RobotSpec) -> None:
    """Make the robot's root a part of the base; only what belongs to it comes along."""
    own, root = robot.spec, robot.root
    ring = [each for each in own.sensors if each.name.startswith("range_")]
    ring += [each for each in own.sites if each.name.startswith("ray_")]
    for element in (*ring, *root.joints, *own.keys, *own.numerics, *own.texts, *own.tuples):
        own.delete(element)
    for field in dir(spec.option):  # the scene's hold: MuJoCo would warn where they differ
        if not field.startswith("_"):
            setattr(own.option, field, getattr(spec.option, field))
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, robot.root_rotation.ravel())
    root.pos, root.quat = robot.root_position, quaternion
    root.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    base.add_frame().attach_body(root, PREFIX, "")
    taken = {sensor.name for sensor in spec.sensors}
    for sensor in spec.sensors:
        plain = sensor.name.removeprefix(PREFIX)
        if plain not in taken:
            sensor.name = plain


def _add_cameras(base: mujoco.MjsBody, robot: RobotSpec) -> None:
    scale = min(max(robot.size / _CHASE_SIZE, _LEAST_SCALE), _MOST_SCALE)
    chase = base.add_camera(name="chase", pos=scale * _CHASE, mode=mujoco.mjtCamLight.mjCAMLIGHT_TRACKCOM)
    x, y, z = robot.laser_place.tolist()
    onboard = base.add_camera(name="onboard", pos=[x, y, z + _ONBOARD_HEIGHT], fovy=70.0)
    portrait = base.add_camera(name="portrait", pos=robot.size / _CHASE_SIZE * _PORTRAIT, fovy=28.0)
    views = (
        (chase, (0, -1, 0, 0.55, 0, 0.83)),
        (onboard, (0, -1, 0, 0.1, 0, 1)),
        (portrait, (0.8, 0.95, 0, -0.456, 0.384, 1.5425)),  # towards (0, 0, 0.14) of the Pioneer
    )
    for camera, axes in views:
        camera.alt.type, camera.alt.xyaxes = mujoco.mjtOrientation.mjORIENTATION_XYAXES, axes
