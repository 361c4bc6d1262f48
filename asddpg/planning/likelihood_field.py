"""The likelihood field: how probable a scan is at many poses at once (Probabilistic Robotics, section 6.4)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from asddpg.planning.costmap import distance_to_obstacles
from asddpg.planning.occupancy_grid import FloatArray, IntArray, OccupancyGrid

Float32Array = npt.NDArray[np.float32]
_LEAST = -700.0  # of a logarithm whose exponential is not 0


class LikelihoodField:
    """Distance from anywhere to the nearest occupied cell of a map.

    Attributes:
        distances: (rows + 2, columns + 2) metres, between centres of cells; the border stands for all outside the map.
        max_distance: metres; longer ones are cut to it, and it holds outside the map.
    """

    def __init__(self, grid: OccupancyGrid, max_distance: float = 2.0) -> None:
        self.max_distance = max_distance
        self.distances: Float32Array = np.pad(
            np.minimum(distance_to_obstacles(grid), max_distance).astype(np.float32),
            1,
            constant_values=max_distance,
        )
        self._scale = np.float32(1.0 / grid.resolution)
        self._offset = tuple(np.float32(1.0 - corner / grid.resolution) for corner in grid.origin)

    def indices_of(self, x: npt.ArrayLike, y: npt.ArrayLike) -> IntArray:
        """Where points (x, y; metres, map frame, of one shape) are found in `distances`, flattened: that shape."""
        rows, columns = self.distances.shape
        column, row = (
            # Cut before they become integers, which far points would overflow.
            np.clip(np.asarray(along, dtype=np.float32) * self._scale + offset, 0, count - 1).astype(np.int32)
            for along, offset, count in zip((x, y), self._offset, (columns, rows), strict=True)
        )
        return np.asarray(row * np.int32(columns) + column, dtype=np.intp)

    def distances_at(self, points: npt.ArrayLike) -> Float32Array:
        """Distances, metres (...), of points x and y, metres, map frame (..., 2)."""
        found = np.asarray(points)
        return np.asarray(self.distances.ravel()[self.indices_of(found[..., 0], found[..., 1])])


@dataclass(frozen=True)
class LaserOptions:
    """Constants of the laser's model; the defaults are those of amcl's node.

    Attributes:
        z_hit: share of beams that end at an obstacle of the map.
        z_rand: share of beams that end anywhere.
        sigma_hit: standard deviation of a beam's end from the obstacle, metres.
        max_beams: of a scan that are used, evenly spaced.
        max_distance: metres; an obstacle farther away than this counts as this far.
        beam_power: 0 sums cubes of the beams' probabilities (likelihood_field of the node); else their product, each
            to this power: 1 takes beams for independent (likelihood_field_prob), less for ones that err alike.
    """

    z_hit: float = 0.95
    z_rand: float = 0.05
    sigma_hit: float = 0.2
    max_beams: int = 30
    max_distance: float = 2.0
    beam_power: float = 0.0


class LikelihoodModel:
    """Weights of poses by a scan."""

    def __init__(self, grid: OccupancyGrid, range_max: float, options: LaserOptions | None = None) -> None:
        """Tabulate what a beam adds that ends in a cell.

        Args:
            grid: the map.
            range_max: of the laser, metres; a beam that long met nothing.
            options: constants.
        """
        self._options = chosen = options or LaserOptions()
        self._range_max = range_max
        self._field = LikelihoodField(grid, chosen.max_distance)
        probability = self.beam_probability(self._field.distances).ravel()
        terms = chosen.beam_power * np.log(probability) if chosen.beam_power else probability**3
        self._terms = terms.astype(np.float32)

    def beam_probability(self, distance: npt.ArrayLike) -> FloatArray:
        """Probability density of beams that end at this distance from an obstacle, metres (...): (...)."""
        ratio = np.asarray(distance, dtype=np.float64) / self._options.sigma_hit
        hit = self._options.z_hit * np.exp(-0.5 * ratio**2)
        return np.asarray(hit + self._options.z_rand / self._range_max)

    def weights(self, lasers: FloatArray, ranges: npt.ArrayLike, angles: npt.ArrayLike) -> FloatArray:
        """Weights of poses by a scan.

        1 and the cube of each beam's probability, or the product of their powers: neighbouring beams err alike, and one
        wrong beam must not rule a pose out.

        Args:
            lasers: poses of the laser, (n, 3), metres and radians, map frame.
            ranges: (beams,) metres; beams without an echo (not finite, not positive, or of the greatest range) are
                left out.
            angles: (beams,) radians, frame of the laser.

        Returns:
            (n,).
        """
        ahead, aside = self._end_points(np.asarray(ranges, np.float64), np.asarray(angles, np.float64))
        x, y, yaw = lasers.T.astype(np.float32)[:, :, None]
        cos, sin = np.cos(yaw), np.sin(yaw)
        cells = self._field.indices_of(x + cos * ahead - sin * aside, y + sin * ahead + cos * aside)
        sums = self._terms.take(cells).sum(axis=1, dtype=np.float64)
        return np.asarray(np.exp(np.maximum(sums, _LEAST)) if self._options.beam_power else 1.0 + sums)

    def _end_points(self, ranges: FloatArray, angles: FloatArray) -> tuple[Float32Array, Float32Array]:
        chosen = evenly_spaced(len(ranges), self._options.max_beams)
        ranges, angles = ranges[chosen], angles[chosen]
        echo = (ranges > 0) & (ranges < self._range_max)  # false for NaN
        ranges, angles = ranges[echo], angles[echo]
        return (ranges * np.cos(angles)).astype(np.float32), (ranges * np.sin(angles)).astype(np.float32)


def evenly_spaced(count: int, at_most: int) -> IntArray:
    """Indices of at most so many of `count` things, evenly spaced, the first and the last among them."""
    return np.round(np.linspace(0, count - 1, min(count, at_most))).astype(np.intp)
