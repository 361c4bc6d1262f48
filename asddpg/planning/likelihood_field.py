"""The likelihood field: how probable a scan is at many poses at once (Probabilistic Robotics, section 6.4)."""

import numpy as np
import numpy.typing as npt

from asddpg.planning.costmap import distance_to_obstacles
from asddpg.planning.occupancy_grid import FloatArray, IntArray, OccupancyGrid

Float32Array = npt.NDArray[np.float32]


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


class LikelihoodModel:
    """Weights of poses by a scan."""

    def __init__(
        self,
        field: LikelihoodField,
        range_max: float,
        z_hit: float = 0.95,
        z_rand: float = 0.05,
        sigma_hit: float = 0.2,
        max_beams: int = 30,
    ) -> None:
        """Tabulate the probability of a beam that ends in a cell.

        Args:
            field: distances to obstacles.
            range_max: of the laser, metres; a beam that long met nothing.
            z_hit: share of beams that end at an obstacle of the map.
            z_rand: share of beams that end anywhere.
            sigma_hit: standard deviation of the distance to the obstacle, metres.
            max_beams: of a scan that are used, evenly spaced.
        """
        self._field = field
        self._range_max = range_max
        self._z_hit, self._z_rand, self._sigma_hit = z_hit, z_rand, sigma_hit
        self._max_beams = max_beams
        self._cubes = (self.beam_probability(field.distances) ** 3).ravel().astype(np.float32)

    def beam_probability(self, distance: npt.ArrayLike) -> FloatArray:
        """Probability density of beams that end at this distance from an obstacle, metres (...): (...)."""
        ratio = np.asarray(distance, dtype=np.float64) / self._sigma_hit
        return np.asarray(self._z_hit * np.exp(-0.5 * ratio**2) + self._z_rand / self._range_max)

    def weights(self, lasers: FloatArray, ranges: npt.ArrayLike, angles: npt.ArrayLike) -> FloatArray:
        """Weights of poses by a scan: 1 and the cube of each beam's probability.

        Cubes, not a product: neighbouring beams err alike, and one wrong beam must not rule a pose out.

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
        return np.asarray(1.0 + self._cubes.take(cells).sum(axis=1, dtype=np.float64))

    def _end_points(self, ranges: FloatArray, angles: FloatArray) -> tuple[Float32Array, Float32Array]:
        chosen = evenly_spaced(len(ranges), self._max_beams)
        ranges, angles = ranges[chosen], angles[chosen]
        echo = (ranges > 0) & (ranges < self._range_max)  # false for NaN
        ranges, angles = ranges[echo], angles[echo]
        return (ranges * np.cos(angles)).astype(np.float32), (ranges * np.sin(angles)).astype(np.float32)


def evenly_spaced(count: int, at_most: int) -> IntArray:
    """Indices of at most so many of `count` things, evenly spaced, the first and the last among them."""
    return np.round(np.linspace(0, count - 1, min(count, at_most))).astype(np.intp)
