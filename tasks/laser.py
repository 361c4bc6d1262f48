"""The laser: its ring of beams in a scene, and the noise, dropout and latency of a real one.

A Hokuyo URG-04LX sees 240° in 682 beams; the paper keeps 40 of them. Both are the ring of models/mjcf/pioneer with
another count.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from tasks.constants import FIELD_OF_VIEW, MAX_RANGE, MIN_RANGE, NUM_BEAMS, PHYSICS_TIMESTEP
from tasks.errors import TaskError
from tasks.generator_state import generator_state, restored_generator
from tasks.options import NOT_NEGATIVE, SHARE, between, check_options, option
from tasks.physics import FloatArray, Physics

# Noise of the URG-04LX: σ = max(0.028, 0.0013 r + 0.0001) m, the sensor model of libpointmatcher.
_NOISE_FLOOR, _NOISE_SLOPE, _NOISE_OFFSET = 0.028, 0.0013, 0.0001


@dataclass
class LaserConfig:
    """What the laser does; by default it is perfect."""

    num_beams: int = option(NUM_BEAMS, "Beams over 240°; 40 in the paper's code, 682 in reality.", between(2, 2000))
    rays_per_beam: int = option(
        1,
        "Rays of a beam, the nearest return of which counts: more of them see thin legs.",
        between(1, 50),
    )
    noise: float = option(0.0, "Scale of the noise on every range; 1 is that of a real URG-04LX, 0 none.", NOT_NEGATIVE)
    dropout: float = option(0.0, "Probability that a beam returns nothing; it then reads the maximum range.", SHARE)
    latency: float = option(0.0, "Seconds from a scan to the end of the step that returns it.", between(0, 2, " s"))

    def __post_init__(self) -> None:
        """TaskError where a value is out of range."""
        check_options(self)

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
            hit = scan < MAX_RANGE
            sigma = self._noise * np.maximum(_NOISE_FLOOR, _NOISE_SLOPE * scan + _NOISE_OFFSET)
            scan = np.where(hit, scan + sigma * self.rng.standard_normal(len(scan)), scan)
        if self._dropout > 0.0:
            scan = np.where(self.rng.random(len(scan)) < self._dropout, MAX_RANGE, scan)
        return np.clip(scan, MIN_RANGE, MAX_RANGE)


def beam_angles(count: int, rays_per_beam: int = 1) -> FloatArray:
    """Angles of the beams from straight ahead, from the rightmost to the leftmost: float64 (count,), radians.

    A beam of several rays points along their middle.
    """
    rays = np.linspace(-FIELD_OF_VIEW / 2, FIELD_OF_VIEW / 2, count * rays_per_beam)
    angles: FloatArray = rays.reshape(count, rays_per_beam).mean(axis=1) if rays_per_beam > 1 else rays
    return angles


def laser_position(model: mujoco.MjModel) -> tuple[float, float]:
    """Place of the laser in the base's frame, metres: x ahead, y to the left.

    Raises:
        TaskError: the robot has no laser.
    """
    sites = [index for index in range(model.nsite) if model.site(index).name.startswith("ray_")]
    if not sites:
        raise TaskError("the robot has no laser: its beams are sites ray_00, ray_01, …")
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    base = data.body("base")
    x, y, _ = (data.site_xpos[sites[0]] - base.xpos) @ base.xmat.reshape(3, 3)
    return float(x), float(y)


def set_beams(spec: mujoco.MjSpec, count: int) -> None:
    """Give the laser of a scene another number of beams over the same field of view.

    Args:
        spec: a scene not yet compiled; changed in place, unless it has no laser.
        count: of beams, 2 or more.
    """
    sites = [site for site in spec.sites if site.name.startswith("ray_")]
    sensors = [sensor for sensor in spec.sensors if sensor.name.startswith("range_")]
    if not sites or not sensors or len(sites) == count:
        return
    body, size, group, rgba = sites[0].parent, sites[0].size.copy(), sites[0].group, sites[0].rgba.copy()
    place = spec.copy().compile().site(sites[0].name).pos  # in the body's frame, whatever frames lie between
    cutoff, reading = sensors[0].cutoff, sensors[0].intprm.copy()
    for element in (*sensors, *sites):
        spec.delete(element)
    digits = len(str(count - 1))
    for index, angle in enumerate(beam_angles(count)):
        number = f"{index:0{digits}d}"
        along = [np.cos(angle), np.sin(angle), 0.0]  # a rangefinder looks along its site's z axis
        site = body.add_site(name=f"ray_{number}", pos=place, size=size, group=group, rgba=rgba)
        site.alt.type, site.alt.zaxis = mujoco.mjtOrientation.mjORIENTATION_ZAXIS, along
        spec.add_sensor(
            name=f"range_{number}",
            type=mujoco.mjtSensor.mjSENS_RANGEFINDER,
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            objname=site.name,
            cutoff=cutoff,
            intprm=reading,
        )
