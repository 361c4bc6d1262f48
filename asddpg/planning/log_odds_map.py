"""A map built while driving, from scans and poses: log-odds of each cell (Moravec and Elfes, 1985)."""

from dataclasses import dataclass

import numpy as np

from asddpg.planning.occupancy_grid import UNKNOWN, FloatArray, IntArray, OccupancyGrid


@dataclass(frozen=True)
class LogOddsOptions:
    """How much a beam proves.

    Attributes:
        hit: added where a beam ends.
        miss: added where a beam passes; little, since beams pass a thin leg in its own cell, and where a pose is off.
        limit: of the sum's magnitude, so that what has moved is soon seen.
    """

    hit: float = 0.85
    miss: float = -0.1
    limit: float = 3.5


class LogOddsMap:
    """Cells' log-odds of being occupied; a cell that no beam met is unknown.

    Attributes:
        grid: the map as an occupancy grid.
    """

    def __init__(self, layout: OccupancyGrid, options: LogOddsOptions | None = None) -> None:
        """Begin with nothing known, in the cells of another map."""
        self._options, self._layout = options or LogOddsOptions(), layout
        self.clear()

    def clear(self) -> None:
        """Forget all scans."""
        self._log_odds = np.zeros(self._layout.cells.size)
        self._cells = np.full(self._layout.cells.size, UNKNOWN, dtype=np.int8)
        self._copy_grid()

    def insert(
        self,
        pose: tuple[float, float, float],
        ranges: FloatArray,
        beams: FloatArray,
        laser: tuple[float, float],
        max_range: float,
    ) -> None:
        """Take a scan.

        Args:
            pose: of the base when it was taken, m and rad, map frame.
            ranges: metres, (num_beams,); inf, or max_range and more, for a beam without a return;
                NaN for one that says nothing.
            beams: their directions in the base's frame, rad, (num_beams,).
            laser: its x and y in the base's frame, metres.
            max_range: a beam without a return has passed so far, metres.
        """
        is_valid = ~np.isnan(ranges)
        ranges, beams = ranges[is_valid], beams[is_valid]
        if not len(ranges):
            return
        x, y, yaw = pose
        cos, sin = np.cos(yaw), np.sin(yaw)
        begin = np.array([x + cos * laser[0] - sin * laser[1], y + sin * laser[0] + cos * laser[1]])
        directions = np.stack([np.cos(yaw + beams), np.sin(yaw + beams)], axis=1)
        is_hit = np.isfinite(ranges) & (ranges < max_range)
        lengths = np.where(is_hit, ranges, max_range)
        hits = self._indices(begin + lengths[is_hit, None] * directions[is_hit])
        hits = np.unique(hits[hits >= 0])
        passed = self._passed(begin, directions, lengths)
        # A cell that one beam ends in is not cleared by others that graze it.
        passed = passed[~np.isin(passed, hits)]
        np.add.at(self._log_odds, passed, self._options.miss)
        self._log_odds[hits] += self._options.hit
        met = np.concatenate([passed, hits])
        self._log_odds[met] = np.clip(self._log_odds[met], -self._options.limit, self._options.limit)
        self._cells[met] = np.rint(100.0 / (1.0 + np.exp(-self._log_odds[met])))
        self._copy_grid()

    def _passed(self, begin: FloatArray, directions: FloatArray, lengths: FloatArray) -> IntArray:
        """Indices of the cells that beams pass before their ends, each cell once a beam."""
        spacing = self._layout.resolution / 2
        distances = np.arange(0.0, lengths.max(), spacing)
        points = begin + distances[None, :, None] * directions[:, None, :]
        indices = self._indices(points)  # [beams, distances]
        is_new = np.ones(indices.shape, dtype=bool)
        is_new[:, 1:] = indices[:, 1:] != indices[:, :-1]
        return indices[is_new & (indices >= 0) & (distances < lengths[:, None])]

    def _indices(self, points: FloatArray) -> IntArray:
        """Flat indices of the cells of points (..., 2); −1 outside."""
        cells = self._layout.to_cells(points)
        indices = cells[..., 0] * self._layout.shape[1] + cells[..., 1]
        return np.where(self._layout.contains(cells), indices, -1)

    def _copy_grid(self) -> None:
        """The grid of before stays as it was: others may hold it."""
        layout = self._layout
        self.grid = OccupancyGrid(self._cells.copy().reshape(layout.shape), layout.resolution, layout.origin)
