"""The laser: its ring of beams in a scene, and the noise, dropout and latency of a real one.

A Hokuyo URG-04LX sees 240° in 682 beams; the paper keeps 40 of them. That ring is in models/mjcf/pioneer; another
laser's replaces it.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import mujoco
import numpy as np

from tasks.constants import FIELD_OF_VIEW, MAX_RANGE, MIN_RANGE, NUM_BEAMS, PHYSICS_TIMESTEP
from tasks.errors import TaskError
from tasks.generator_state import generator_state, restored_generator
from tasks.options import NOT_NEGATIVE, SHARE, Range, between, check_options, option
from tasks.physics import LEAST_RANGE, FloatArray, Physics

# Noise of the URG-04LX: σ = max(0.028, 0.0013 r + 0.0001) m, the sensor model of libpointmatcher.
_NOISE_FLOOR, _NOISE_SLOPE, _NOISE_OFFSET = 0.028, 0.0013, 0.0001


FIELDS_OF_VIEW = Range(lambda degrees: 0.0 < degrees <= 360.0, "above 0 and up to 360")


class BeamRing(NamedTuple):
    """What the beams of a laser are, whatever its noise.

    Attributes:
        num_beams: 2 or more, evenly spread.
        field_of_view: degrees, about straight ahead.
        min_range: metres; a shorter range reads this.
        max_range: metres; a longer one, and none at all, read this.
        height: metres above the floor; None leaves the laser where the robot has it.
    """

    num_beams: int = NUM_BEAMS
    field_of_view: float = FIELD_OF_VIEW
    min_range: float = MIN_RANGE
    max_range: float = MAX_RANGE
    height: float | None = None

    def angles(self) -> FloatArray:
        """Of the beams from straight ahead, from the rightmost to the leftmost: float64 (num_beams,), radians.

        All round, the first beam points straight back, and there is no last one beside it.
        """
        half = np.radians(self.field_of_view) / 2
        return np.linspace(-half, half, self.num_beams, endpoint=self.field_of_view < 360.0)


@dataclass
class LaserConfig:
    """What the laser does; by default it is perfect."""

    num_beams: int = option(
        NUM_BEAMS,
        "Beams, evenly spread over the field of view; 40 in the paper's code, 682 in reality.",
        between(2, 2000),
    )
    rays_per_beam: int = option(
        1,
        "Rays of a beam, the nearest return of which counts: more of them see thin legs.",
        between(1, 50),
    )
    noise: float = option(0.0, "Scale of the noise on every range; 1 is that of a real URG-04LX, 0 none.", NOT_NEGATIVE)
    dropout: float = option(0.0, "Probability that a beam returns nothing; it then reads the maximum range.", SHARE)
    latency: float = option(0.0, "Seconds from a scan to the end of the step that returns it.", between(0, 2, " s"))
    field_of_view: float = option(
        FIELD_OF_VIEW, "Degrees from the first beam to the last; 360 is all round.", FIELDS_OF_VIEW
    )
    min_range: float = option(MIN_RANGE, "Metres; shorter ranges read this.", between(0, 10))
    max_range: float = option(
        MAX_RANGE, "Metres; longer ranges and beams that meet nothing read this.", between(0.1, 100)
    )
    height: float | None = option(
        None, "Metres of the beams above the floor; null leaves the laser where the robot has it.", between(0.02, 2)
    )

    def __post_init__(self) -> None:
        """TaskError where a value is out of range."""
        check_options(self)
        if not self.min_range < self.max_range:
            raise TaskError(f"min_range must be below max_range, {self.max_range}, not {self.min_range}")

    @property
    def ring(self) -> BeamRing:
        """Its rays in the scene."""
        return BeamRing(self.num_rays, self.field_of_view, self.min_range, self.max_range, self.height)

    def angles(self) -> FloatArray:
        """Of the beams in its scans from straight ahead, from right to left: float64 (num_beams,), radians.

        A beam of several rays points along their middle.
        """
        rays = self.ring.angles()
        return rays if self.rays_per_beam == 1 else rays.reshape(-1, self.rays_per_beam).mean(axis=1)

    @property
    def num_rays(self) -> int:
        """Rays of the scene's ring."""
        return self.num_beams * self.rays_per_beam


def pool_rays(ranges: FloatArray, rays_per_beam: int) -> FloatArray:
    """The nearest return of each beam's rays: (..., beams · rays) → (..., beams), metres."""
    if rays_per_beam == 1:
        return ranges
    pooled: FloatArray = ranges.reshape(*ranges.shape[:-1], -1, rays_per_beam).min(axis=-1)
    return pooled


class Laser:
    """Reads a scan once a control step, with the noise, dropout and latency of its configuration.

    Attributes:
        latency: seconds from a scan to the end of the step that returns it, in whole physics steps; at an episode's
            beginning the first scan is returned until a later one arrives.
    """

    def __init__(self, config: LaserConfig, control_timestep: float, rng: np.random.Generator) -> None:
        """Make the laser; `rng` is its own stream, so that noise changes no start and no goal."""
        self.config = config
        self.rng = rng
        self._control_timestep = control_timestep
        self._waiting: deque[FloatArray] = deque()
        self._read_at = -1.0
        self._set_faults(0.0, 0.0, 0.0)

    def _set_faults(self, noise: float, dropout: float, latency: float) -> None:
        """Add to the faults of the configuration."""
        config = self.config
        self._noise, self._dropout = config.noise + noise, min(config.dropout + dropout, 1.0)
        self._late_steps, self._late_seconds = divmod(config.latency + latency + 1e-9, self._control_timestep)
        within_step = round(self._late_seconds / PHYSICS_TIMESTEP) * PHYSICS_TIMESTEP
        self.latency = self._late_steps * self._control_timestep + within_step
        self._waiting = deque(self._waiting, maxlen=int(self._late_steps) + 1)

    @property
    def is_perfect(self) -> bool:
        """Whether it returns every range as it is, at once."""
        return self.config.noise == self.config.dropout == self.config.latency == 0.0

    def state(self) -> dict[str, Any]:
        """The random stream of the noise and the delayed scans: plain values and arrays."""
        return {"rng": generator_state(self.rng), "waiting": list(self._waiting), "read_at": self._read_at}

    def load_state(
        self, state: Mapping[str, Any], noise: float = 0.0, dropout: float = 0.0, latency: float = 0.0
    ) -> None:
        """Restore what state() returned in an episode that began with those faults."""
        self._set_faults(noise, dropout, latency)
        self.rng = restored_generator(state["rng"])
        self._waiting.clear()
        self._waiting.extend(state["waiting"])
        self._read_at = state["read_at"]

    def begin_episode(self, physics: Physics, noise: float = 0.0, dropout: float = 0.0, latency: float = 0.0) -> None:
        """Drop the scans of the last episode; this one's noise, dropout and latency (s) add to the configuration's."""
        self._set_faults(noise, dropout, latency)
        self._waiting.clear()
        self._read_at = -1.0
        physics.scan_delay = self._late_seconds

    def ranges(self, physics: Physics) -> FloatArray:
        """The scan that arrives now: float64 (num_beams,), metres; at one instant always the same."""
        if physics.time() != self._read_at:
            self._read_at = physics.time()
            scan = physics.delayed_ranges() if self._waiting else physics.ranges()
            self._waiting.append(self._disturbed(scan))
        return pool_rays(self._waiting[0], self.config.rays_per_beam).copy()

    def _disturbed(self, scan: FloatArray) -> FloatArray:
        if self._noise > 0.0:
            hit = scan < self.config.max_range
            sigma = self._noise * np.maximum(_NOISE_FLOOR, _NOISE_SLOPE * scan + _NOISE_OFFSET)
            scan = np.where(hit, scan + sigma * self.rng.standard_normal(len(scan)), scan)
        if self._dropout > 0.0:
            scan = np.where(self.rng.random(len(scan)) < self._dropout, self.config.max_range, scan)
        return np.clip(scan, self.config.min_range, self.config.max_range)


def laser_position(model: mujoco.MjModel) -> tuple[float, float, float]:
    """Place of the laser in the base's frame, metres: x ahead, y to the left, z up.

    Raises:
        TaskError: the robot has no laser.
    """
    sites = [index for index in range(model.nsite) if model.site(index).name.startswith("ray_")]
    if not sites:
        raise TaskError("the robot has no laser: its beams are sites ray_00, ray_01, …")
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    base = data.body("base")
    x, y, z = (data.site_xpos[sites[0]] - base.xpos) @ base.xmat.reshape(3, 3)
    return float(x), float(y), float(z)


def set_beams(spec: mujoco.MjSpec, ring: BeamRing) -> None:
    """Give a scene another laser.

    Args:
        spec: a scene not yet compiled; changed in place, unless it has no laser.
        ring: its beams; those of the scene itself, if as many, are taken to be over 240°.

    Raises:
        TaskError: at that height the beams would meet the robot.
    """
    sites = [site for site in spec.sites if site.name.startswith("ray_")]
    sensors = [sensor for sensor in spec.sensors if sensor.name.startswith("range_")]
    if not sites or not sensors:
        return
    if (len(sites), FIELD_OF_VIEW) != (ring.num_beams, ring.field_of_view):
        sensors = _replace_ring(spec, sites, sensors, ring.angles())
    for sensor in sensors:
        sensor.cutoff = ring.max_range
    if ring.min_range != MIN_RANGE or spec.numeric(LEAST_RANGE) is not None:
        numeric = spec.numeric(LEAST_RANGE) or spec.add_numeric(name=LEAST_RANGE)
        numeric.size, numeric.data = 1, [ring.min_range]
    if ring.height is not None:
        _set_height(spec, ring.height)


def _replace_ring(
    spec: mujoco.MjSpec, sites: list[mujoco.MjsSite], sensors: list[mujoco.MjsSensor], angles: FloatArray
) -> list[mujoco.MjsSensor]:
    """Beams at other angles in the place of the present ones; the new sensors."""
    body, size, group, rgba = sites[0].parent, sites[0].size.copy(), sites[0].group, sites[0].rgba.copy()
    place = spec.copy().compile().site(sites[0].name).pos  # in the body's frame, whatever frames lie between
    reading = sensors[0].intprm.copy()
    for element in (*sensors, *sites):
        spec.delete(element)
    digits, added = len(str(len(angles) - 1)), []
    for index, angle in enumerate(angles):
        number = f"{index:0{digits}d}"
        along = [np.cos(angle), np.sin(angle), 0.0]  # a rangefinder looks along its site's z axis
        site = body.add_site(name=f"ray_{number}", pos=place, size=size, group=group, rgba=rgba)
        site.alt.type, site.alt.zaxis = mujoco.mjtOrientation.mjORIENTATION_ZAXIS, along
        added.append(
            spec.add_sensor(
                name=f"range_{number}",
                type=mujoco.mjtSensor.mjSENS_RANGEFINDER,
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=site.name,
                intprm=reading,
            )
        )
    return added


def _set_height(spec: mujoco.MjSpec, height: float) -> None:
    """Move the laser up or down: with its housing, the body `laser`, or where that is but a frame, its beams beside."""
    model = spec.copy().compile()
    own, frame = laser_position(model)[2], spec.body("laser")
    beams = [site for site in spec.sites if site.name.startswith("ray_") and site.parent.name != "laser"]
    for element in (*beams, *([frame] if frame else [])):
        element.pos[2] += height - own
    model = spec.copy().compile()
    is_robot = model.body_rootid[model.geom_bodyid] == model.body("base").id
    model.geom_rgba[~is_robot, 3], model.geom_matid[~is_robot] = 0.0, -1  # rays pass what is not to be seen
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    sensors = [index for index in range(model.nsensor) if model.sensor(index).name.startswith("range_")]
    blocked = int((data.sensordata[model.sensor_adr[sensors]] >= 0.0).sum())
    if blocked:
        seen = f"{blocked} of its {len(sensors)} beams would end at the robot itself"
        raise TaskError(f"laser.height must lie above the robot, whose laser is at {own:g} m: at {height:g} m {seen}")
