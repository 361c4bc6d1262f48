"""A scan of one laser as another laser would have it: beams by angle, ranges clipped."""

import numpy as np
import numpy.typing as npt

from asddpg.errors import UserError
from tasks.laser import LaserConfig, pool_rays

FloatArray = npt.NDArray[np.float64]

MIN_TOLERANCE = np.radians(2.0)  # a beam stands for one so far from it, or farther where beams are farther apart


class ScanResampler:
    """Gives scans of any laser the beams of one.

    A beam reads what the nearest valid beam of the scan reads, at most one spacing of its own laser or 2° away,
    whichever is more; one of several rays reads the least of what these find so. By REP 117 +inf is no return, −inf too
    near, NaN invalid; 0 and less are invalid too, as drivers use them. Without a valid beam so near it reads the
    greatest range, like a lost return in training.
    """

    def __init__(self, laser: LaserConfig) -> None:
        self._laser = laser
        self._wanted = laser.ring.angles()  # of the rays
        self._tolerance = max(float(np.diff(laser.angles()).max()), MIN_TOLERANCE)
        self._angles: FloatArray = np.full(1, np.nan)  # of the last scan; equal to none before
        self._candidates: npt.NDArray[np.intp] = np.zeros((0, 0), dtype=np.intp)  # by ray, nearest first
        self._is_near: npt.NDArray[np.bool_] = np.zeros((0, 0), dtype=np.bool_)

    def resample(self, ranges: npt.ArrayLike, angles: npt.ArrayLike) -> FloatArray:
        """The scan with the laser's beams: float64 (num_beams,), metres.

        Args:
            ranges: (n,) metres.
            angles: (n,) radians from straight ahead, to the left positive, in any order and of any turn.

        Raises:
            UserError: the scan has no beam where the laser has one; no beam of it is valid; or it is no scan.
        """
        measured, directions = (np.asarray(values, dtype=np.float64) for values in (ranges, angles))
        if measured.ndim != 1 or measured.shape != directions.shape or not np.isfinite(directions).all():
            shapes = f"{measured.shape} and {directions.shape}"
            raise UserError(
                f"a scan has a range and a finite angle, rad, for each beam, not ranges and angles of {shapes}"
            )
        self.match(directions)
        is_valid = (measured > 0.0) | (measured == -np.inf)  # false for NaN
        if not is_valid.any():
            raise UserError(
                f"none of the scan's {len(measured)} beams is valid: +inf is no return, a range is above 0 m"
            )
        is_usable = self._is_near & is_valid[self._candidates]
        first = is_usable.argmax(axis=1)
        rows = np.arange(len(first))
        found = np.where(is_usable[rows, first], measured[self._candidates[rows, first]], np.inf)
        found = np.clip(found, self._laser.min_range, self._laser.max_range)
        return pool_rays(found, self._laser.rays_per_beam)

    def match(self, angles: FloatArray) -> None:
        """Find which beams of scans stand for which rays of the laser; UserError where one has none."""
        if np.array_equal(angles, self._angles):
            return
        turns = self._wanted[:, None] - angles
        distances = np.abs((turns + np.pi) % (2 * np.pi) - np.pi)  # [ray, beam of the scan]
        is_near = distances <= self._tolerance
        beams = self._laser.angles()
        missing = beams[~is_near.any(axis=1).reshape(len(beams), -1).all(axis=1)]
        if len(missing):
            lacking = f"{len(missing)} of the policy's {len(beams)} beams, the first at {np.degrees(missing[0]):.0f}°"
            needed = f"over {self._laser.field_of_view:g}°, within {np.degrees(self._tolerance):.1f}° of its own"
            raise UserError(f"the scan lacks {lacking}: the policy needs beams {needed}")
        count = int(is_near.sum(axis=1).max())
        self._candidates = np.argsort(distances, axis=1, kind="stable")[:, :count]
        self._is_near = np.take_along_axis(is_near, self._candidates, axis=1)
        self._angles = angles.copy()
