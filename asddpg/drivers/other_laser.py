"""A policy that drives by another laser than its own."""

import numpy as np

from asddpg.deployment.scan_resampling import ScanResampler
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.protocols import Agent, Observation
from tasks.laser import LaserConfig

_NO_RETURN = 0.5  # in the observation, of a beam that reads the maximum range


def with_other_laser(driver: Agent, num_scans: int, own: LaserConfig, other: LaserConfig) -> FixedDriver:
    """A driver of observations with the one laser as a driver of observations with the other.

    Args:
        driver: decides by its own laser.
        num_scans: in the observations of both.
        own: the driver's laser.
        other: the robot's.

    Raises:
        UserError: the robot's laser does not see where the driver's does.
    """
    resampler, angles, size = ScanResampler(own), other.angles(), num_scans * other.num_beams
    resampler.match(angles)

    def resample(observation: Observation) -> Observation:
        scans = observation[:size].reshape(num_scans, other.num_beams).astype(np.float64)
        ranges = np.where(scans < _NO_RETURN, (scans + 0.5) * other.max_range, np.inf)
        found = np.concatenate([resampler.resample(scan, angles) for scan in ranges])
        return np.concatenate((found / own.max_range - 0.5, observation[size:]), dtype=np.float32, casting="same_kind")

    return FixedDriver(lambda observation: driver.decide(resample(observation)))
