"""The one place that knows MuJoCo's indices: named readings in SI units, as copies, and which contact is a crash."""

import math
import zlib
from collections.abc import Mapping
from typing import Any, NamedTuple, Self

import mujoco
import numpy as np
import numpy.typing as npt
from dm_control import mujoco as dm_mujoco

from tasks.constants import MAX_RANGE, MAX_SONAR_RANGE, MIN_RANGE, MIN_SONAR_RANGE
from tasks.errors import TaskError
from tasks.graphics.rendering import OffscreenRenderer, Picture
from tasks.robots.drive import Drive

FloatArray = npt.NDArray[np.float64]

MOVABLE_GROUP = 1  # geom group of class `movable` in models/mjcf/rooms/common.xml
# Physics steps between two checks of the contacts: 25 ms at 5 ms a step. A graze shorter than the control step counts.
STEPS_BETWEEN_CONTACT_CHECKS = 5
LEAST_RANGE = "laser_min_range"  # a numeric of a scene whose laser has another one than MIN_RANGE
_SENSORS_OFF = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
_FULL_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)  # with less of it a continuation drifts by 4e-6
_CRASH, _PUSH = 1, 2  # kinds of contact between two geoms; 0 is any other


class Pose(NamedTuple):
    """Position (m) and yaw (rad, counter-clockwise from x) of the robot's base on the floor, world frame."""

    x: float
    y: float
    yaw: float


class Velocity(NamedTuple):
    """Forward speed (m/s) and turn rate (rad/s) of the base, robot frame."""

    linear: float
    angular: float


class Readings(NamedTuple):
    """Pose, velocity and goal at one instant.

    Attributes:
        pose: of the base, world frame.
        velocity: of the base, robot frame.
        goal: x and y, metres, world frame.
        goal_in_robot_frame: the goal ahead of (x) and to the left of (y) the base, metres.
        goal_distance: between base and goal, metres.
    """

    pose: Pose
    velocity: Velocity
    goal: tuple[float, float]
    goal_in_robot_frame: tuple[float, float]
    goal_distance: float


def _find_range_limits(model: mujoco.MjModel) -> tuple[float, float]:
    """Least and greatest range of a scene's laser, metres; without a laser the constants."""
    numerics = [model.numeric(index) for index in range(model.nnumeric)]
    sensors = [model.sensor(index) for index in range(model.nsensor)]
    low = next((float(numeric.data[0]) for numeric in numerics if numeric.name == LEAST_RANGE), MIN_RANGE)
    high = next((float(sensor.cutoff[0]) for sensor in sensors if sensor.name.startswith("range_")), MAX_RANGE)
    return low, high or MAX_RANGE  # 0 is no cutoff


def compute_digest(positions: bytes, velocities: bytes) -> int:
    """CRC-32 of the bytes of qpos and qvel: it identifies a state to the last bit."""
    return zlib.crc32(velocities, zlib.crc32(positions))


class Physics(dm_mujoco.Physics):  # type: ignore[misc]  # dm_control has no types
    """A scene with a robot on two driven wheels: commands in, readings out.

    Scans belong to the state they are read with: the sensors are switched off during the physics steps and evaluated
    once, on the final state, which also spares the rays of every other physics step.

    Attributes:
        drive: the robot's wheels.
        min_range: of the laser, metres.
        max_range: of the laser, metres.
    """

    drive: Drive

    def _reload_from_data(self, data: object) -> None:
        super()._reload_from_data(data)
        model = self.model.ptr
        base = model.body("base").id
        self._goal_mocap = int(model.body("goal").mocapid[0])
        self._base_qpos, self._base_qvel = (
            int(at[0]) for at in (model.joint("base").qposadr, model.joint("base").dofadr)
        )
        self.drive = Drive.from_model(model)
        self._wheels = [(wheel.actuator, wheel.gain) for wheel in self.drive.wheels]
        self._wheel_qpos = [(int(model.jnt_qposadr[wheel.joint]), wheel.direction) for wheel in self.drive.wheels]
        self._robot_bodies = set(np.flatnonzero(np.asarray(model.body_rootid) == base).tolist())
        self._ranges, self._sonar_ranges = self._find_ring("range_"), self._find_ring("sonar_")
        self.min_range, self.max_range = _find_range_limits(model)
        robot = np.asarray(model.body_rootid)[model.geom_bodyid] == base
        movable = np.asarray(model.geom_group) == MOVABLE_GROUP
        obstacle = ~robot & ~movable
        obstacle[model.geom("floor").id] = False
        kinds = _CRASH * np.outer(robot, obstacle) + _PUSH * np.outer(robot, movable & ~robot)
        # Nested lists, not an array: looking up three or four pairs is several times faster in plain Python.
        self._contact_kinds: list[list[int]] = (kinds + kinds.T).tolist()
        self._geom_bodies: list[int] = model.geom_bodyid.tolist()
        self._crashed = False
        self._crashed_into = -1  # geom
        self._pushed: set[int] = set()
        self._scratch: mujoco.MjData | None = None
        # Seconds from the instant of a step's scan to the step's end; a laser with latency sets it.
        self.scan_delay = 0.0
        self._delayed: FloatArray | None = None
        # Its instant, s, and the bytes of xpos, xquat and xmat at it: recordings place the scan by them.
        self.delayed_poses: tuple[float, bytes] | None = None

    def _find_ring(self, prefix: str) -> slice:
        """Slice of all sensor readings that holds those of the rangefinders of a name."""
        sensors = [self.model.ptr.sensor(index) for index in range(self.model.ptr.nsensor)]
        places = [int(sensor.adr[0]) for sensor in sensors if sensor.name.startswith(prefix)]
        begin = places[0] if places else 0
        if places != list(range(begin, begin + len(places))):
            raise ValueError(f"the scene's rangefinders {prefix}00, {prefix}01, … must follow one another")
        return slice(begin, begin + len(places))

    @property
    def num_beams(self) -> int:
        """Beams of the laser."""
        return int(self._ranges.stop - self._ranges.start)

    # State ----------------------------------------------------------------------------------------------------------

    def after_reset(self) -> None:
        """Make every reading fit the state; a pickle, a copy and a reset context end here.

        dm_control's own leaves actuation out. The next step begins with mj_step2, and would miss the wheels' feedback.
        """
        super().after_reset()
        with self.model.disable("sensor"):  # these are right already
            mujoco.mj_step1(self.model.ptr, self.data.ptr)

    def full_state(self) -> dict[str, Any]:
        """Everything that the steps to come depend on: plain values and arrays."""
        return {
            "integration": self.get_state(_FULL_STATE),
            "crashed": self._crashed,
            "pushed": sorted(self._pushed),
            "scan_delay": self.scan_delay,
            "delayed_scan": self._delayed,
        }

    def load_full_state(self, state: Mapping[str, Any]) -> None:
        """Restore what full_state() returned; the next steps are equal to the last bit.

        Raises:
            TaskError: it is the state of another scene.
        """
        size = mujoco.mj_stateSize(self.model.ptr, _FULL_STATE)
        if np.shape(state["integration"]) != (size,):
            found = np.size(state["integration"])
            raise TaskError(f"the state is of another scene: it has {found} numbers of MuJoCo's state, not {size}")
        self.set_state(state["integration"], _FULL_STATE)
        mujoco.mj_step1(self.model.ptr, self.data.ptr)
        self._crashed, self._pushed = state["crashed"], set(state["pushed"])
        self.scan_delay, self._delayed, self.delayed_poses = state["scan_delay"], state["delayed_scan"], None

    def state_digest(self) -> int:
        """The present state's compute_digest()."""
        return compute_digest(self.data.ptr.qpos.tobytes(), self.data.ptr.qvel.tobytes())

    def copy(self, share_model: bool = False) -> Self:
        """A copy in the same state, with the same model if `share_model`."""
        copied: Self = super().copy(share_model)
        copied.load_full_state(self.full_state())
        return copied

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy.deepcopy."""
        return {"data": self.data, "state": self.full_state()}

    def __setstate__(self, pickled: dict[str, Any]) -> None:
        """Restore what __getstate__() gave."""
        super().__setstate__(pickled["data"])
        self.load_full_state(pickled["state"])

    # Commands -----------------------------------------------------------------------------------------------------

    def set_velocity_command(self, linear: float, angular: float) -> None:
        """Command the wheels' speeds for a forward speed (m/s) and a turn rate (rad/s) of the base.

        The turn rate is cut at the robot's limit here, a wheel's speed at its limit by the actuator.
        """
        _, radius, track, _, limit, _ = self.drive
        half_turn = 0.5 * track * min(max(angular, -limit), limit)
        self.set_wheel_speeds((linear - half_turn) / radius, (linear + half_turn) / radius)

    def set_wheel_speeds(self, left: float, right: float) -> None:
        """Command the wheels' speeds forward, rad/s."""
        ctrl = self.data.ptr.ctrl
        for (actuator, gain), speed in zip(self._wheels, (left, right), strict=True):
            ctrl[actuator] = gain * speed

    def set_pose(self, pose: Pose) -> None:
        """Put the base on the floor at `pose`, at rest and touching nothing yet."""
        self._crashed, self._delayed, self.delayed_poses = False, None, None
        self._pushed.clear()
        self.data.ptr.qvel[:] = 0.0
        self._place(self.data.ptr, pose)

    def set_safety_margin(self, metres: float) -> None:
        """Count a collision, or a push, from this distance on; no force and no motion changes."""
        model = self.model.ptr
        model.geom_gap[np.isin(model.geom_bodyid, [*self._robot_bodies])] = metres

    def _place(self, data: mujoco.MjData, pose: Pose) -> None:
        start, half_yaw = self._base_qpos, 0.5 * pose.yaw
        data.qpos[start : start + 7] = [pose.x, pose.y, 0.0, math.cos(half_yaw), 0.0, 0.0, math.sin(half_yaw)]

    def set_goal(self, x: float, y: float) -> None:
        """Put the goal at (x, y), metres, world frame; within an episode too, without any effect on the motion."""
        self.data.ptr.mocap_pos[self._goal_mocap] = [x, y, 0.0]
        mujoco.mj_kinematics(self.model.ptr, self.data.ptr)  # the positions of all bodies are up to date at once

    # Stepping -----------------------------------------------------------------------------------------------------

    def step(self, nstep: int = 1) -> None:
        """Advance by `nstep` physics steps; afterwards every position and velocity reading is of the final state."""
        model, data = self.model.ptr, self.data.ptr
        options = model.opt
        self._crashed = False
        self._pushed.clear()
        delay_steps = min(round(self.scan_delay / options.timestep), nstep)
        with self.check_invalid_state():
            flags = options.disableflags
            options.disableflags = flags | _SENSORS_OFF
            try:
                if delay_steps:
                    self._advance(nstep - delay_steps)
                    options.disableflags = flags
                    mujoco.mj_step1(model, data)
                    options.disableflags = flags | _SENSORS_OFF
                    self._delayed = self.ranges()
                    poses = (data.xpos, data.xquat, data.xmat)
                    self.delayed_poses = data.time, b"".join(part.tobytes() for part in poses)
                self._advance(delay_steps or nstep)
            finally:
                options.disableflags = flags
            mujoco.mj_step1(model, data)
        self._record_contacts()

    def _advance(self, nstep: int) -> None:
        model, data = self.model.ptr, self.data.ptr
        if nstep:
            # The last mj_step1 or mj_forward left positions and velocities ready: finish that step first.
            mujoco.mj_step2(model, data)
        done = 1
        while done < nstep:
            chunk = min(STEPS_BETWEEN_CONTACT_CHECKS, nstep - done)
            mujoco.mj_step(model, data, chunk)
            self._record_contacts()
            done += chunk

    def _record_contacts(self) -> None:
        kinds = self._contact_kinds
        for first, second in self.data.ptr.contact.geom.tolist():
            kind = kinds[first][second]
            if kind == _CRASH:
                self._crashed = True
                self._crashed_into = second if self._geom_bodies[first] in self._robot_bodies else first
            elif kind == _PUSH:
                self._pushed |= {self._geom_bodies[first], self._geom_bodies[second]} - self._robot_bodies

    def render(
        self, height: int = 240, width: int = 320, camera_id: str | int = "chase", *args: Any, **options: Any
    ) -> Picture:
        """A picture of the scene, uint8 (height, width, 3), by a camera's name or number, −1 the overall view.

        dm_control's own opens a screen first, and serves one thread of one process; it draws what only it can: depth,
        overlays, and whatever else is given. For many pictures keep an OffscreenRenderer (tasks.graphics.rendering).
        """
        if args or options:
            drawn: Picture = super().render(height, width, camera_id, *args, **options)
            return drawn
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
        return self._read_ranges(self._ranges, self.min_range, self.max_range)

    def delayed_ranges(self) -> FloatArray:
        """The same, `scan_delay` seconds before the end of the last step()."""
        return self.ranges() if self._delayed is None or not self.scan_delay else self._delayed.copy()

    def wheel_angles(self) -> tuple[float, float]:
        """Angles that the left and the right wheel have rolled forward, rad, without wrapping: perfect encoders."""
        qpos, ((left, ahead_left), (right, ahead_right)) = self.data.ptr.qpos, self._wheel_qpos
        return ahead_left * float(qpos[left]), ahead_right * float(qpos[right])

    def sonar_ranges(self) -> FloatArray:
        """Distances along the sonars, from sonar_00 at the left front clockwise: float64 (num_sonars,), metres.

        (0,) for a robot without sonars.
        """
        return self._read_ranges(self._sonar_ranges, MIN_SONAR_RANGE, MAX_SONAR_RANGE)

    def _read_ranges(self, part: slice, low: float, high: float) -> FloatArray:
        readings: FloatArray = self.data.ptr.sensordata[part].copy()
        readings[readings < 0.0] = high  # MuJoCo's "no hit"
        return np.clip(readings, low, high, out=readings)

    def is_free(self, pose: Pose) -> bool:
        """Whether the robot, put at `pose` into the scene as its file has it, touches nothing but the floor."""
        data = mujoco.MjData(self.model.ptr)
        self._place(data, pose)
        mujoco.mj_kinematics(self.model.ptr, data)
        mujoco.mj_collision(self.model.ptr, data)
        return not any(self._contact_kinds[first][second] for first, second in data.contact.geom.tolist())

    def sensor(self, name: str) -> FloatArray:
        """A sensor's reading in the present state, in the units of its kind: float64 (dim,).

        Forces and accelerations (`accelerometer`, `bumper`) are computed on a copy: reading changes no trajectory.

        Raises:
            TaskError: there is no sensor of that name.
        """
        model = self.model.ptr
        names = [model.sensor(index).name for index in range(model.nsensor)]
        if name not in names:
            raise TaskError(f"there is no sensor {name!r}; there are {', '.join(names)}")
        if self._scratch is None:
            self._scratch = mujoco.MjData(model)
        mujoco.mj_copyData(self._scratch, model, self.data.ptr)
        mujoco.mj_forward(model, self._scratch)
        reading: FloatArray = self._scratch.sensor(name).data.copy()
        return reading

    def views(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Views of the base's qpos, (7,), and qvel, (6,), and of the beams, (num_beams,): MuJoCo keeps them up to date.

        A beam that meets nothing is negative.
        """
        qpos, qvel, data = self._base_qpos, self._base_qvel, self.data.ptr
        return data.qpos[qpos : qpos + 7], data.qvel[qvel : qvel + 6], data.sensordata[self._ranges]

    def pose(self) -> Pose:
        """Pose of the base in the world frame."""
        x, y, _, qw, qx, qy, qz = self.data.ptr.qpos[self._base_qpos : self._base_qpos + 7].tolist()
        return Pose(x, y, math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz)))

    def goal(self) -> tuple[float, float]:
        """Goal in the world frame, metres."""
        x, y, _ = self.data.ptr.mocap_pos[self._goal_mocap].tolist()
        return x, y

    def readings(self) -> Readings:
        """Pose, velocity and goal together, which costs less than one after the other."""
        pose = self.pose()
        vx, vy, _, _, _, yaw_rate = self.data.ptr.qvel[self._base_qvel : self._base_qvel + 6].tolist()
        goal = self.goal()
        dx, dy = goal[0] - pose.x, goal[1] - pose.y
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        velocity = Velocity(vx * cos + vy * sin, yaw_rate)
        return Readings(pose, velocity, goal, (cos * dx + sin * dy, cos * dy - sin * dx), math.hypot(dx, dy))

    def crashed(self) -> bool:
        """Whether the robot touched anything but the floor and class `movable` during the last step()."""
        return self._crashed

    def touched(self) -> tuple[str, ...]:
        """Names of what the robot touched during the last step(), the floor apart: a geom, and movable bodies."""
        model = self.model.ptr
        crashed = (model.geom(self._crashed_into).name or "an obstacle without a name",) if self._crashed else ()
        return (*crashed, *(model.body(body).name for body in sorted(self._pushed)))

    def num_pushed(self) -> int:
        """How many movable things the robot touched during the last step()."""
        return len(self._pushed)
