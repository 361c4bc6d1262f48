"""The one place that knows MuJoCo's indices: named readings of a scene, in SI units, as copies."""

import math
from typing import NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt
from dm_control import mujoco as dm_mujoco

from tasks.constants import MAX_RANGE, MIN_RANGE, TRACK, WHEEL_RADIUS
from tasks.rendering import OffscreenRenderer, Picture

FloatArray = npt.NDArray[np.float64]

MOVABLE_GROUP = 1  # geom group of class `movable` in models/mjcf/rooms/common.xml
# Physics steps between two looks at the contacts: 25 ms at 5 ms a step. A graze shorter than the control step counts.
STEPS_BETWEEN_CONTACT_CHECKS = 5
_SENSORS_OFF = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)


class Pose(NamedTuple):
    """Position (m) and yaw (rad, counter-clockwise from x) of the robot's base on the floor, world frame."""

    x: float
    y: float
    yaw: float


class Velocity(NamedTuple):
    """Forward speed (m/s) and turn rate (rad/s) of the base, robot frame."""

    linear: float
    angular: float


class Physics(dm_mujoco.Physics):  # type: ignore[misc]  # dm_control has no types
    """A scene with a Pioneer: commands in, readings out.

    Scans belong to the state they are read with: the sensors are switched off during the physics steps and evaluated
    once, on the final state, which also spares the rays of every other physics step.
    """

    def _reload_from_data(self, data: object) -> None:
        super()._reload_from_data(data)
        model = self.model.ptr
        geom = mujoco.mjtObj.mjOBJ_GEOM
        self._base_body = self._id(mujoco.mjtObj.mjOBJ_BODY, "base")
        self._goal_mocap = int(model.body_mocapid[self._id(mujoco.mjtObj.mjOBJ_BODY, "goal")])
        joint = self._id(mujoco.mjtObj.mjOBJ_JOINT, "base")
        self._base_qpos = int(model.jnt_qposadr[joint])
        self._base_qvel = int(model.jnt_dofadr[joint])
        self._wheels = [self._id(mujoco.mjtObj.mjOBJ_ACTUATOR, f"{side}_wheel") for side in ("left", "right")]
        self._ranges = self._range_slice()
        robot = np.asarray(model.body_rootid)[model.geom_bodyid] == self._base_body
        harmless = np.asarray(model.geom_group) == MOVABLE_GROUP
        harmless[self._id(geom, "floor")] = True
        obstacle = ~robot & ~harmless
        pairs = np.outer(robot, obstacle)
        # Nested lists, not an array: looking up three or four pairs is several times faster in plain Python.
        self._is_crash: list[list[bool]] = (pairs | pairs.T).tolist()
        self._crashed = False

    def _id(self, kind: mujoco.mjtObj, name: str) -> int:
        index: int = mujoco.mj_name2id(self.model.ptr, kind, name)
        if index < 0:
            raise ValueError(f"the scene lacks the {kind.name[6:].lower()} {name!r} that every robot scene must have")
        return index

    def _range_slice(self) -> slice:
        model = self.model.ptr
        beams = np.flatnonzero(np.asarray(model.sensor_type) == mujoco.mjtSensor.mjSENS_RANGEFINDER)
        if not len(beams):
            raise ValueError("the scene lacks rangefinder sensors range_00, range_01, …")
        addresses = np.asarray(model.sensor_adr)[beams]
        if np.any(np.diff(addresses) != 1):
            raise ValueError("the scene's rangefinders must stand one after the other")
        return slice(int(addresses[0]), int(addresses[-1]) + 1)

    @property
    def num_beams(self) -> int:
        """Beams of the laser."""
        return int(self._ranges.stop - self._ranges.start)

    # Commands -----------------------------------------------------------------------------------------------------

    def set_velocity_command(self, linear: float, angular: float) -> None:
        """Command the wheels' speeds for a forward speed (m/s) and a turn rate (rad/s) of the base."""
        half_turn = 0.5 * TRACK * angular
        ctrl = self.data.ptr.ctrl
        ctrl[self._wheels[0]] = (linear - half_turn) / WHEEL_RADIUS
        ctrl[self._wheels[1]] = (linear + half_turn) / WHEEL_RADIUS

    def set_pose(self, pose: Pose) -> None:
        """Put the base on the floor at `pose`, at rest."""
        self.data.ptr.qvel[:] = 0.0
        start = self._base_qpos
        half_yaw = 0.5 * pose.yaw
        self.data.ptr.qpos[start : start + 7] = [pose.x, pose.y, 0.0, math.cos(half_yaw), 0.0, 0.0, math.sin(half_yaw)]

    def set_goal(self, x: float, y: float) -> None:
        """Put the goal at (x, y), metres, world frame."""
        self.data.ptr.mocap_pos[self._goal_mocap] = [x, y, 0.0]

    # Stepping -----------------------------------------------------------------------------------------------------

    def step(self, nstep: int = 1) -> None:
        """Advance by `nstep` physics steps; afterwards every position and velocity reading is of the final state."""
        model, data = self.model.ptr, self.data.ptr
        options = model.opt
        self._crashed = False
        with self.check_invalid_state():
            flags = options.disableflags
            options.disableflags = flags | _SENSORS_OFF
            try:
                # The last mj_step1 or mj_forward left positions and velocities ready: finish that step first.
                mujoco.mj_step2(model, data)
                done = 1
                while done < nstep:
                    chunk = min(STEPS_BETWEEN_CONTACT_CHECKS, nstep - done)
                    mujoco.mj_step(model, data, chunk)
                    self._note_crash()
                    done += chunk
            finally:
                options.disableflags = flags
            mujoco.mj_step1(model, data)
        self._note_crash()

    def _note_crash(self) -> None:
        is_crash = self._is_crash
        for first, second in self.data.ptr.contact.geom.tolist():
            if is_crash[first][second]:
                self._crashed = True

    def render(self, height: int = 240, width: int = 320, camera_id: str | int = "chase") -> Picture:
        """A picture of the scene, uint8 (height, width, 3), by a camera's name or number, −1 the overall view.

        dm_control's own would open a screen first; of its arguments these are kept. For many pictures keep an
        OffscreenRenderer (tasks.rendering), which also takes an mujoco.MjData; depth is mujoco.Renderer's.
        """
        renderer = OffscreenRenderer(self.model.ptr, width, height)
        try:
            return renderer.render(self.data.ptr, camera_id)
        finally:
            renderer.close()

    # Readings -----------------------------------------------------------------------------------------------------

    def ranges(self) -> FloatArray:
        """Distances along the beams, from the rightmost to the leftmost: float64 (num_beams,), metres.

        A beam that meets nothing reads the maximum range.
        """
        readings: FloatArray = self.data.ptr.sensordata[self._ranges].copy()
        readings[readings < 0.0] = MAX_RANGE  # MuJoCo's "no hit"
        return np.clip(readings, MIN_RANGE, MAX_RANGE, out=readings)

    def pose(self) -> Pose:
        """Pose of the base in the world frame."""
        x, y, _, qw, qx, qy, qz = self.data.ptr.qpos[self._base_qpos : self._base_qpos + 7].tolist()
        return Pose(x, y, math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz)))

    def velocity(self) -> Velocity:
        """Velocity of the base in the robot frame."""
        vx, vy, _, _, _, yaw_rate = self.data.ptr.qvel[self._base_qvel : self._base_qvel + 6].tolist()
        yaw = self.pose().yaw
        return Velocity(vx * math.cos(yaw) + vy * math.sin(yaw), yaw_rate)

    def goal(self) -> tuple[float, float]:
        """Goal in the world frame, metres."""
        x, y, _ = self.data.ptr.mocap_pos[self._goal_mocap].tolist()
        return x, y

    def goal_in_robot_frame(self) -> tuple[float, float]:
        """Goal ahead of (x) and to the left of (y) the base, metres."""
        pose = self.pose()
        goal_x, goal_y = self.goal()
        dx, dy = goal_x - pose.x, goal_y - pose.y
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        return cos * dx + sin * dy, cos * dy - sin * dx

    def goal_distance(self) -> float:
        """Distance between base and goal, metres."""
        pose = self.pose()
        goal_x, goal_y = self.goal()
        return math.hypot(goal_x - pose.x, goal_y - pose.y)

    def crashed(self) -> bool:
        """Whether the robot touched anything but the floor and class `movable` during the last step()."""
        return self._crashed
