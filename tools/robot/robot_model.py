"""Properties of the compiled robot: mass, inertia, drive, shape, beams; all from mjModel, none from constants.

They hold in the reference pose, with the frame of `base` on the world's: x forward, y left, z up, on the floor midway
between the drive wheels.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from tasks.physics import FloatArray
from tasks.room_geometry.footprints import Footprint, colliding_robot_geoms
from tasks.room_geometry.geom_shapes import extent

X, Y, Z = np.eye(3)
SIDES = ("left_wheel", "right_wheel")


@dataclass(frozen=True)
class RangefinderRing:
    """Rangefinders with the same name prefix."""

    beams: int
    field_of_view: float  # rad, from the first beam to the last
    place: FloatArray  # (3,) m, the middle of their places
    range: float  # m; 0 is without limit


class RobotModel:
    """The robot of a compiled scene."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Put the base's frame onto the world's and compute the forward dynamics."""
        self.model = model
        self.data = mujoco.MjData(model)
        self.base = int(model.body("base").id)
        start = int(model.joint("base").qposadr[0])
        self.data.qpos[start : start + 7] = [0, 0, 0, 1, 0, 0, 0]
        mujoco.mj_forward(model, self.data)
        self.bodies = [int(body) for body in np.flatnonzero(model.body_rootid == self.base)]
        self.geoms = [int(geom) for geom in np.flatnonzero(np.isin(model.geom_bodyid, self.bodies))]
        self.solid = colliding_robot_geoms(model)

    # Mass ---------------------------------------------------------------------------------------------------------

    def masses(self) -> dict[str, float]:
        """Mass of each body, kg."""
        return {self.model.body(body).name: float(self.model.body_mass[body]) for body in self.bodies}

    def mass(self) -> float:
        """Mass of the robot, kg."""
        return float(self.model.body_subtreemass[self.base])

    def centre_of_mass(self) -> FloatArray:
        """Centre of mass of the robot, (3,) m, base frame."""
        return np.array(self.data.subtree_com[self.base])

    def inertia(self) -> FloatArray:
        """Inertia of the robot, its joints held, about its centre of mass: (3, 3) kg·m², axes of the base."""
        total = np.zeros((3, 3))
        for body in self.bodies:
            axes = self.data.ximat[body].reshape(3, 3)
            offset = self.data.xipos[body] - self.centre_of_mass()
            shifted = offset @ offset * np.eye(3) - np.outer(offset, offset)
            total += axes * self.model.body_inertia[body] @ axes.T + self.model.body_mass[body] * shifted
        return total

    # Drive --------------------------------------------------------------------------------------------------------

    def wheel_geom(self, side: str = SIDES[0]) -> int:
        """The geom that a wheel rolls on: the lowest solid one of its body."""
        joint = self._driven_joint(side)
        body = int(self.model.jnt_bodyid[joint])
        return self._lowest([geom for geom in self.solid if self.model.geom_bodyid[geom] == body])

    def wheel_radius(self) -> float:
        """Height of a wheel's axle above its lowest point, m."""
        axle = float(self.data.xanchor[self._driven_joint()][2])
        return axle - extent(self.model, self.data, [self.wheel_geom()], Z)[0]

    def track(self) -> float:
        """Distance between the wheels' contact points, m."""
        left, right = (self.data.geom_xpos[self.wheel_geom(side)] for side in SIDES)
        return abs(float(left[1] - right[1]))

    def wheel_speed_limit(self) -> float:
        """Largest speed command of a wheel's actuator, rad/s; infinite where it is not limited."""
        actuator = self.model.actuator(SIDES[0])
        return float(actuator.ctrlrange[1]) if actuator.ctrllimited[0] else np.inf

    def wheel_torque_limit(self) -> float:
        """Largest torque on the wheel, N·m: actuator, its gear and joint together; infinite where not limited."""
        actuator, joint = self.model.actuator(SIDES[0]), self._driven_joint()
        gear = abs(float(actuator.gear[0]))
        limits = [np.inf]
        if actuator.forcelimited[0]:
            limits.append(gear * float(actuator.forcerange[1]))
        if self.model.jnt_actfrclimited[joint]:
            limits.append(float(self.model.jnt_actfrcrange[joint][1]))
        return min(limits)

    def servo_gain(self) -> float:
        """Torque on the wheel per rad/s of speed error, N·m·s/rad."""
        actuator = self.model.actuator(SIDES[0])
        return -float(actuator.biasprm[2]) * float(actuator.gear[0]) ** 2

    def spin_inertia(self) -> float:
        """Inertia of a wheel about its axle with the armature of its joint, kg·m²."""
        unit, result = np.zeros(self.model.nv), np.zeros(self.model.nv)
        dof = int(self.model.jnt_dofadr[self._driven_joint()])
        unit[dof] = 1.0
        mujoco.mj_mulM(self.model, self.data, result, unit)
        return float(result[dof])

    def friction(self) -> float:
        """Sliding friction between wheel and floor by MuJoCo's rule: that of higher priority, else the larger."""
        pair = [self.wheel_geom(), int(self.model.geom("floor").id)]
        priority = self.model.geom_priority[pair]
        sliding = self.model.geom_friction[pair, 0]
        return float(sliding.max() if priority[0] == priority[1] else sliding[np.argmax(priority)])

    # Shape --------------------------------------------------------------------------------------------------------

    def footprint(self) -> Mapping[str, tuple[float, float]]:
        """Least and largest x, y and z of the colliding geoms, m, base frame."""
        return {
            name: extent(self.model, self.data, self.solid, axis) for name, axis in zip("xyz", (X, Y, Z), strict=True)
        }

    def overall_height(self) -> float:
        """Height of the whole robot above the floor, m."""
        return extent(self.model, self.data, self.geoms, Z)[1]

    def circumscribed_radius(self) -> float:
        """Radius of the circle around the colliding geoms, about the axle's middle, m; with Footprint's accuracy."""
        return Footprint.from_model(self.model).radius

    def caster_contact(self) -> FloatArray | None:
        """The caster's contact point, (3,) m, base frame; None where no body with a solid geom is named caster."""
        geoms = [g for g in self.solid if "caster" in self.model.body(int(self.model.geom_bodyid[g])).name]
        if not geoms:
            return None
        lowest = self._lowest(geoms)
        height = extent(self.model, self.data, [lowest], Z)[0]
        return np.array([*self.data.geom_xpos[lowest][:2], height])

    def load_on_wheels(self) -> float:
        """Share of the weight on the drive wheels at rest; 1 without a caster."""
        caster = self.caster_contact()
        axle = float(self.data.xanchor[self._driven_joint()][0])
        return 1.0 if caster is None else float((self.centre_of_mass()[0] - caster[0]) / (axle - caster[0]))

    # Sensors ------------------------------------------------------------------------------------------------------

    def rangefinder_rings(self) -> dict[str, RangefinderRing]:
        """The rangefinders by name prefix: `range` for range_00 and so on."""
        groups: dict[str, list[int]] = {}
        for sensor in np.flatnonzero(self.model.sensor_type == mujoco.mjtSensor.mjSENS_RANGEFINDER):
            groups.setdefault(_prefix(self.model.sensor(sensor).name), []).append(int(sensor))
        return {name: self._ring(sensors) for name, sensors in groups.items()}

    def _ring(self, sensors: list[int]) -> RangefinderRing:
        sites = self.model.sensor_objid[sensors]
        beams = self.data.site_xmat[sites].reshape(-1, 3, 3)[:, :, 2]
        steps = np.diff(np.unwrap(np.arctan2(beams[:, 1], beams[:, 0])))
        place = (self.data.site_xpos[sites].min(axis=0) + self.data.site_xpos[sites].max(axis=0)) / 2
        return RangefinderRing(
            len(sensors), float(np.abs(steps).sum()), place, float(self.model.sensor_cutoff[sensors[0]])
        )

    def sensors(self) -> dict[str, list[str]]:
        """Names of the sensors by kind, numbered ones as `range_00 … range_39`."""
        kinds: dict[str, dict[str, list[str]]] = {}
        for index in range(self.model.nsensor):
            kind = mujoco.mjtSensor(int(self.model.sensor_type[index])).name[7:].lower()
            name = str(self.model.sensor(index).name)
            kinds.setdefault(kind, {}).setdefault(_prefix(name), []).append(name)
        return {
            kind: [names[0] if len(names) == 1 else f"{names[0]} … {names[-1]}" for names in groups.values()]
            for kind, groups in kinds.items()
        }

    def cameras(self) -> dict[str, tuple[FloatArray, float]]:
        """The robot's cameras: position, (3,) m, base frame, and vertical field of view, rad."""
        model = self.model
        return {
            model.cam(index).name: (np.array(self.data.cam_xpos[index]), float(np.deg2rad(model.cam_fovy[index])))
            for index in range(model.ncam)
            if model.cam_bodyid[index] in self.bodies
        }

    # ---------------------------------------------------------------------------------------------------------------

    def _driven_joint(self, side: str = SIDES[0]) -> int:
        return int(self.model.actuator(side).trnid[0])

    def _lowest(self, geoms: list[int]) -> int:
        return min(geoms, key=lambda geom: extent(self.model, self.data, [geom], Z)[0])


def _prefix(name: str) -> str:
    """A name without its trailing number."""
    return re.sub(r"_?\d+$", "", name)
