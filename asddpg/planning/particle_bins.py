"""Bins of particles: how many particles a belief needs (KLD-sampling), and its clusters."""

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array, csgraph

from asddpg.planning.occupancy_grid import FloatArray, IntArray

# Half of a bin's 26 neighbours; the other half have it as theirs.
_NEIGHBOURS = np.array([step for step in itertools.product((-1, 0, 1), repeat=3) if step > (0, 0, 0)])


@dataclass(frozen=True)
class BinSize:
    """Size of a bin.

    Attributes:
        length: along x and along y, metres.
        angle: in yaw, radians; made a whole part of a turn.
    """

    length: float = 0.5
    angle: float = float(np.radians(10.0))


class ParticleBins:
    """The bins that particles lie in.

    Attributes:
        of_particle: (n,) number of each particle's bin.
        count: number of bins that hold a particle.
    """

    def __init__(self, particles: FloatArray, size: BinSize) -> None:
        """Find the bins of particles (n, 3)."""
        self._angles = max(1, round(2 * np.pi / size.angle))
        cells = np.floor(particles / (size.length, size.length, 2 * np.pi / self._angles)).astype(np.int64)
        cells[:, :2] -= cells[:, :2].min(axis=0) - 1  # from 1 on: row 0 is left empty between two columns
        self._rows = int(cells[:, 1].max()) + 1
        keys = self._keys_of(cells)
        self._keys, self._first, self.of_particle = np.unique(keys, return_index=True, return_inverse=True)
        self._cells = cells[self._first]
        self.count = len(self._keys)

    def _keys_of(self, cells: IntArray) -> IntArray:
        x, y, yaw = np.moveaxis(cells, -1, 0)
        return np.asarray((x * self._rows + y) * self._angles + yaw % self._angles)

    def counts_so_far(self) -> IntArray:
        """Number of bins that hold one of the first 1, 2, … n particles: (n,)."""
        is_new = np.zeros(len(self.of_particle), dtype=np.intp)
        is_new[self._first] = 1
        return np.cumsum(is_new)

    def clusters(self) -> IntArray:
        """Number of each particle's cluster, (n,): bins that touch, if only in a corner, are in one."""
        neighbours = self._keys_of(self._cells[:, None] + _NEIGHBOURS)
        found = np.minimum(np.searchsorted(self._keys, neighbours), self.count - 1)
        bins, step = np.nonzero(self._keys[found] == neighbours)
        links = coo_array((np.ones(len(bins)), (bins, found[bins, step])), shape=(self.count, self.count))
        _, cluster_of_bin = csgraph.connected_components(links, directed=False)
        return np.asarray(cluster_of_bin[self.of_particle], dtype=np.intp)


def kld_number(bins: npt.ArrayLike, error: float, z: float) -> FloatArray:
    """Particles that a belief over so many bins (...) needs: (...), whole numbers (Fox, 2003, equation 7).

    With these the Kullback-Leibler divergence from the true belief is below `error` with the probability whose
    standard normal quantile is `z`. Beliefs of a single bin need none.
    """
    freedom = np.maximum(np.asarray(bins, dtype=np.float64) - 1.0, 0.0)
    spread = 2.0 / (9.0 * np.maximum(freedom, 1.0))
    return np.asarray(np.ceil(freedom / (2.0 * error) * (1.0 - spread + np.sqrt(spread) * z) ** 3))
