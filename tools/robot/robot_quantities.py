"""Quantities of the compiled robot: mass, drive, shape, sensors; all from mjModel, none from constants.

They hold in the reference pose, with the frame of `base` on the world's: x forward, y left, z up, on the floor midway
between the drive wheels.
"""

import re
from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from tasks.physics import FloatArray
from tasks.robots.drive import Drive
from tasks.robots.opening import DrivenSpeeds
from tasks.room_geometry.footprints import Footprint, colliding_robot_geoms
from tasks.room_geometry.geom_shapes import extent

AXES = dict(zip("xyz", np.eye(3), strict=True))


class Quantity(NamedTuple):
    """A value with its unit and, where its name is not enough, a note."""

    value: float | list[float] | list[str] | None
    unit: str = ""
    note: str = ""


Section = dict[str, Quantity]


class RobotQuantities:
    """The robot of a compiled scene.

    Attributes:
        sections: all quantities by section and name.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        """Put the base's frame onto the world's, compute the forward dynamics and measure."""
        self._model, self._data = model, mujoco.MjData(model)
        self._base = int(model.body("base").id)
        start = int(model.joint("base").qposadr[0])
        self._data.qpos[start : start + 7] = [0, 0, 0, 1, 0, 0, 0]
        mujoco.mj_forward(model, self._data)
        self._bodies = [int(body) for body in np.flatnonzero(model.body_rootid == self._base)]
        self._solid = colliding_robot_geoms(model)
        self._drive_read = Drive.from_model(model)
        self._joint = self._drive_read.wheels[0].joint
        self._axle: FloatArray = self._data.xanchor[self._joint]  # m
        self._wheels = [self._lowest([int(model.jnt_bodyid[wheel.joint])]) for wheel in self._drive_read.wheels]
        self.sections: dict[str, Section] = {
            "mass": self._mass(),
            **self._drive(),
            "footprint": self._footprint(),
            **self._rangefinders(),
            "sensors": self._sensors(),
            "cameras": self._cameras(),
        }

    def _mass(self) -> Section:
        model, data = self._model, self._data
        centre, inertia = data.subtree_com[self._base], np.zeros((3, 3))
        for body in self._bodies:
            axes, offset = data.ximat[body].reshape(3, 3), data.xipos[body] - centre
            shifted = offset @ offset * np.eye(3) - np.outer(offset, offset)
            inertia += axes * model.body_inertia[body] @ axes.T + model.body_mass[body] * shifted
        return {
            "total": Quantity(float(model.body_subtreemass[self._base]), "kg"),
            **{f"body {model.body(body).name}": Quantity(float(model.body_mass[body]), "kg") for body in self._bodies},
            "centre of mass": _vector(centre, "m", "x, y, z in the frame of base"),
            "inertia": _vector(np.diag(inertia), "kg·m²", "xx, yy, zz about the centre of mass, joints held"),
            "inertia, products": _vector(inertia[[0, 0, 1], [1, 2, 2]], "kg·m²", "xy, xz, yz"),
        }

    def _drive(self) -> dict[str, Section]:
        wheel, radius, track = self._drive_read.wheels[0], self._drive_read.radius, self._drive_read.track
        actuator, speed = self._model.actuator(wheel.actuator), wheel.speed_limit
        torque, inertia, friction = self._torque_limit(), self._spin_inertia(), self._friction()
        rolling_mass = float(self._model.body_subtreemass[self._base]) + 2 * inertia / radius**2
        grip, share = friction * abs(float(self._model.opt.gravity[2])), self._load_on_wheels()
        drive = {
            "wheel radius": Quantity(radius, "m"),
            "track": Quantity(track, "m", "between the wheels' contact points"),
            "wheel speed limit": _limit(speed, "rad/s"),
            "wheel torque limit": _limit(torque, "N·m"),
            "velocity servo": Quantity(-float(actuator.biasprm[2] * actuator.gear[0] ** 2), "N·m·s/rad"),
            "wheel inertia": Quantity(inertia, "kg·m²", "about the axle, armature included"),
            "friction on the floor": Quantity(friction),
        }
        against = "wheels at their limit, against each other"
        performance = {
            "speed": _limit(speed * radius, "m/s", "both wheels at their limit"),
            "turn rate": _limit(2 * speed * radius / track, "rad/s", against),
            "acceleration by torque": _limit(
                2 * torque / radius / rolling_mass, "m/s²", "from rest, with the wheels' spin"
            ),
            "acceleration by grip": Quantity(grip, "m/s²", "mu·g, all weight on the wheels"),
            "weight on the wheels": Quantity(100 * share, "%", "at rest; the caster carries the rest"),
            "acceleration by that grip": Quantity(grip * share, "m/s²", "mu·g times that share"),
        }
        return {"drive": drive, "performance of the drive": performance}

    def _torque_limit(self) -> float:
        """Largest torque on the wheel, N·m: actuator, its gear and joint together; infinite where not limited."""
        actuator = self._model.actuator(self._drive_read.wheels[0].actuator)
        by_actuator = abs(actuator.gear[0]) * actuator.forcerange[1] if actuator.forcelimited[0] else np.inf
        is_limited = self._model.jnt_actfrclimited[self._joint]
        return float(min(by_actuator, self._model.jnt_actfrcrange[self._joint][1] if is_limited else np.inf))

    def _spin_inertia(self) -> float:
        """Inertia of a wheel about its axle with the armature of its joint, kg·m²."""
        unit, result = np.zeros(self._model.nv), np.zeros(self._model.nv)
        dof = int(self._model.jnt_dofadr[self._joint])
        unit[dof] = 1.0
        mujoco.mj_mulM(self._model, self._data, result, unit)
        return float(result[dof])

    def _friction(self) -> float:
        """Sliding friction between wheel and floor by MuJoCo's rule: that of higher priority, else the larger."""
        pair = [self._wheels[0], int(self._model.geom("floor").id)]
        priority, sliding = self._model.geom_priority[pair], self._model.geom_friction[pair, 0]
        return float(sliding.max() if priority[0] == priority[1] else sliding[np.argmax(priority)])

    def _load_on_wheels(self) -> float:
        """Share of the weight on the drive wheels at rest; 1 without a caster."""
        caster, centre = self._caster_contact(), self._data.subtree_com[self._base]
        return 1.0 if caster is None else float((centre[0] - caster[0]) / (self._axle[0] - caster[0]))

    def _caster_contact(self) -> FloatArray | None:
        """The caster's contact point, (3,) m; None where no solid geom, nor its body, is named caster."""
        model = self._model
        casters = [
            geom
            for geom in self._solid
            if "caster" in model.geom(geom).name or "caster" in model.body(model.geom_bodyid[geom]).name
        ]
        if not casters:
            return None
        lowest = min(casters, key=lambda geom: self._extent([geom], "z")[0])
        return np.array([*self._data.geom_xpos[lowest][:2], self._extent([lowest], "z")[0]])

    def _footprint(self) -> Section:
        spans = [self._extent(self._solid, axis) for axis in AXES]
        caster = self._caster_contact()
        geoms = [int(geom) for geom in np.flatnonzero(np.isin(self._model.geom_bodyid, self._bodies))]
        return {
            **{
                name: Quantity(high - low, "m", f"{axis} from {low:z.4f} to {high:z.4f}")
                for name, axis, (low, high) in zip(("length", "width", "height"), AXES, spans, strict=True)
            },
            "height, visual parts included": Quantity(self._extent(geoms, "z")[1], "m"),
            "circumscribed radius": Quantity(
                Footprint.from_model(self._model).radius, "m", "about the middle of the axle"
            ),
            "caster": Quantity(None, "", "none") if caster is None else _vector(caster, "m", "x, y, z where it stands"),
        }

    def _rangefinders(self) -> dict[str, Section]:
        """The rangefinders by name prefix: `range` for range_00 and so on."""
        rings: dict[str, list[int]] = {}
        for sensor in np.flatnonzero(self._model.sensor_type == mujoco.mjtSensor.mjSENS_RANGEFINDER):
            rings.setdefault(_prefix(self._model.sensor(sensor).name), []).append(int(sensor))
        return {f"rangefinders {name}": self._ring(sensors) for name, sensors in rings.items()}

    def _ring(self, sensors: list[int]) -> Section:
        sites = self._model.sensor_objid[sensors]
        beams, places = self._data.site_xmat[sites].reshape(-1, 3, 3)[:, :, 2], self._data.site_xpos[sites]
        view = np.abs(np.diff(np.unwrap(np.arctan2(beams[:, 1], beams[:, 0])))).sum()
        middle = (places.min(axis=0) + places.max(axis=0)) / 2
        return {
            "beams": Quantity(len(sensors)),
            "field of view": Quantity(float(np.rad2deg(view)), "deg", "from the first beam to the last"),
            "place": _vector(middle, "m", "x, y, z in the frame of base, middle of them all"),
            "range": _limit(float(self._model.sensor_cutoff[sensors[0]]) or np.inf, "m"),
        }

    def _sensors(self) -> Section:
        """Names of the sensors by kind, numbered ones as `range_00 … range_39`."""
        kinds: dict[str, dict[str, list[str]]] = {}
        for index in range(self._model.nsensor):
            kind = mujoco.mjtSensor(int(self._model.sensor_type[index])).name[7:].lower()
            name = str(self._model.sensor(index).name)
            kinds.setdefault(kind, {}).setdefault(_prefix(name), []).append(name)
        return {
            kind: Quantity([names[0] if len(names) == 1 else f"{names[0]} … {names[-1]}" for names in groups.values()])
            for kind, groups in kinds.items()
        }

    def _cameras(self) -> Section:
        model = self._model
        return {
            model.cam(index).name: _vector(
                [*self._data.cam_xpos[index], model.cam_fovy[index]], "m, m, m, deg", "x, y, z, vertical field of view"
            )
            for index in range(model.ncam)
            if model.cam_bodyid[index] in self._bodies
        }

    def _extent(self, geoms: Sequence[int], axis: str) -> tuple[float, float]:
        return extent(self._model, self._data, geoms, AXES[axis])

    def _lowest(self, bodies: Sequence[int]) -> int:
        """The lowest solid geom of some bodies."""
        geoms = [geom for geom in self._solid if self._model.geom_bodyid[geom] in bodies]
        return min(geoms, key=lambda geom: self._extent([geom], "z")[0])


def driven_section(speeds: DrivenSpeeds) -> Section:
    """What a robot drives on an empty floor, beside what was commanded."""
    names, units = ("straight on", "on the spot"), ("m/s", "rad/s")
    return {
        name: Quantity(driven, unit, f"{command:.4g} {unit} commanded: {100 * (driven / command - 1):+.2f} %")
        for name, unit, command, driven in zip(names, units, *speeds, strict=True)
    }


def _prefix(name: str) -> str:
    """A name without its trailing number."""
    return re.sub(r"_?\d+$", "", name)


def _vector(values: Sequence[float] | FloatArray, unit: str, note: str) -> Quantity:
    return Quantity([float(value) for value in values], unit, note)


def _limit(value: float, unit: str, note: str = "") -> Quantity:
    return Quantity(float(value), unit, note) if np.isfinite(value) else Quantity(None, unit, "not limited")
