"""Adaptive Monte Carlo localisation on a known map, after the amcl node of ROS."""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from asddpg.planning.likelihood_field import LaserOptions, LikelihoodModel
from asddpg.planning.occupancy_grid import FloatArray, OccupancyGrid
from asddpg.planning.odometry import MotionNoise, relative_motion, sample_motion
from asddpg.planning.particle_bins import BinSize, ParticleBins, kld_number
from asddpg.planning.poses import compose, mean_pose, pose_between, pose_covariance, wrap_angle


@dataclass(frozen=True)
class AMCLOptions:
    """Constants of the filter; the defaults are the node's.

    Attributes:
        min_particles: fewest particles.
        max_particles: most particles, and the number at a start.
        kld_error: Kullback-Leibler divergence of the particles from the belief that is accepted.
        kld_z: standard normal quantile of the probability that the divergence is below `kld_error`.
        bin_length: side of a bin along x and along y, metres.
        bin_angle: side of a bin in yaw, radians.
        update_distance: the filter is updated once the robot has moved this far, metres.
        update_angle: or once it has turned this far, radians.
        resample_interval: updates from one resampling to the next.
        noise: of the motion.
        laser: of its model.
        alpha_slow: rate of the slow average of the scans' likelihood; 0 draws no random particles.
        alpha_fast: rate of the fast average; random particles are drawn while it is below the slow one.
    """

    min_particles: int = 100
    max_particles: int = 5000
    kld_error: float = 0.01
    kld_z: float = 0.99
    bin_length: float = 0.5
    bin_angle: float = float(np.radians(10.0))
    update_distance: float = 0.2
    update_angle: float = float(np.pi / 6)
    resample_interval: int = 2
    noise: MotionNoise = field(default_factory=MotionNoise)
    laser: LaserOptions = field(default_factory=LaserOptions)
    alpha_slow: float = 0.0
    alpha_fast: float = 0.0


class AMCL:
    """Estimates the robot's pose on a map from odometry and laser scans.

    Unlike in the node, a belief in a single bin has the fewest particles, not the most; the averages that decide on
    random particles do not depend on the number of particles; bins touch where yaw wraps; and a scan is thinned to
    `laser.max_beams` even if it has fewer than twice as many.

    Attributes:
        particles: (n, 3) x, y, yaw; metres and radians, map frame; of the time of the last filter update.
        weights: (n,), their sum is 1.
        rng: source of randomness.
    """

    particles: FloatArray
    weights: FloatArray
    _odometry: FloatArray | None  # at the last filter update
    _mean: FloatArray | None  # the estimate at the last filter update, computed when first read

    def __init__(
        self,
        grid: OccupancyGrid,
        range_max: float,
        rng: np.random.Generator,
        laser_pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        options: AMCLOptions | None = None,
    ) -> None:
        """Make a filter that may be anywhere on the map, as after start_anywhere().

        Args:
            grid: the map.
            range_max: of the laser, metres.
            rng: source of randomness.
            laser_pose: x, y and yaw of the laser in the robot's frame, metres and radians.
            options: constants.

        Raises:
            ValueError: the map has no free cell.
        """
        self.options = chosen = options or AMCLOptions()
        self._grid, self.rng, self._laser_pose = grid, rng, laser_pose
        self._free = np.argwhere(~grid.occupied & ~grid.unknown)
        if not len(self._free):
            raise ValueError("the map needs a free cell")
        self._scan_model = LikelihoodModel(grid, range_max, chosen.laser)
        self._bin_size = BinSize(chosen.bin_length, chosen.bin_angle)
        needed = kld_number(np.arange(chosen.max_particles + 1), chosen.kld_error, chosen.kld_z)
        self._enough = np.clip(needed, chosen.min_particles, chosen.max_particles)  # by number of bins
        self.start_anywhere()

    def start_at(self, pose: npt.ArrayLike, spread: npt.ArrayLike) -> None:
        """Begin near a pose, with normally distributed particles.

        Args:
            pose: x, y, yaw; metres and radians, map frame.
            spread: standard deviations (3,) or covariance (3, 3).
        """
        given = np.asarray(spread, dtype=np.float64)
        covariance = np.diag(given**2) if given.ndim == 1 else given
        mean = np.asarray(pose, dtype=np.float64)
        drawn = self.rng.multivariate_normal(mean, covariance, self.options.max_particles, method="eigh")
        drawn[:, 2] = wrap_angle(drawn[:, 2])
        self._begin(drawn)

    def start_anywhere(self) -> None:
        """Begin with particles uniform over the free cells of the map, with any yaw."""
        self._begin(self._random_poses(self.options.max_particles))

    def update(self, odometry_pose: npt.ArrayLike, ranges: npt.ArrayLike, angles: npt.ArrayLike) -> bool:
        """Take the readings of a control step.

        The first readings after a start are weighed at once, later ones only when the robot has moved enough.

        Args:
            odometry_pose: x, y, yaw; metres and radians, odometry frame.
            ranges: (beams,) metres.
            angles: (beams,) radians, frame of the laser.

        Returns:
            Whether the particles were updated.
        """
        self._newest_odometry = np.array(odometry_pose, dtype=np.float64)
        if self._odometry is not None:
            if not self._has_moved(self._odometry, self._newest_odometry):
                return False
            motion = relative_motion(self._odometry, self._newest_odometry)
            self.particles = sample_motion(self.particles, motion, self.options.noise, self.rng)
        self._odometry = self._newest_odometry
        self._weigh(ranges, angles)
        self._updates += 1
        if self._updates % self.options.resample_interval == 0:
            self._resample()
        self._mean = None
        return True

    def pose(self) -> FloatArray:
        """The estimate, now: x, y, yaw; metres and radians, map frame, (3,).

        It is the mean of the heaviest cluster, moved by the odometry since the last filter update.
        """
        if self._mean is None:
            self._mean = self._mean_of_heaviest_cluster()
        return compose(self._mean, self._motion_since_update())

    def covariance(self) -> FloatArray:
        """Covariance of all particles about the estimate, now, map frame: (3, 3) of x, y, yaw in m² and rad²."""
        return pose_covariance(compose(self.particles, self._motion_since_update()), self.weights, self.pose())

    def _begin(self, particles: FloatArray) -> None:
        self.particles = particles
        self.weights = np.full(len(particles), 1.0 / len(particles))
        self._odometry = None
        self._newest_odometry = np.zeros(3)
        self._updates = 0
        self._slow_average = self._fast_average = 0.0
        self._mean = None

    def _random_poses(self, count: int) -> FloatArray:
        cells = self._free[self.rng.integers(len(self._free), size=count)]
        within = self.rng.uniform(-0.5, 0.5, (count, 2)) * self._grid.resolution
        yaw = self.rng.uniform(-np.pi, np.pi, (count, 1))
        return np.hstack((self._grid.to_points(cells) + within, yaw))

    def _has_moved(self, before: FloatArray, after: FloatArray) -> bool:
        x, y, turn = after - before
        far, turned = np.hypot(x, y) >= self.options.update_distance, abs(wrap_angle(turn)) >= self.options.update_angle
        return bool(far or turned)

    def _motion_since_update(self) -> FloatArray:
        return np.zeros(3) if self._odometry is None else pose_between(self._odometry, self._newest_odometry)

    def _weigh(self, ranges: npt.ArrayLike, angles: npt.ArrayLike) -> None:
        lasers = compose(self.particles, self._laser_pose)
        weights = self.weights * self._scan_model.weights(lasers, ranges, angles)
        likelihood = float(weights.sum())  # the particles' mean, since the old weights sum to 1
        self.weights = weights / likelihood
        if self._slow_average == 0.0:
            self._slow_average = self._fast_average = likelihood
        self._slow_average += self.options.alpha_slow * (likelihood - self._slow_average)
        self._fast_average += self.options.alpha_fast * (likelihood - self._fast_average)

    def _resample(self) -> None:
        # Independent draws, not low-variance ones: those need the number beforehand, and it follows from the draws.
        drawn = self._draw(self.options.max_particles)
        bins_so_far = ParticleBins(drawn, self._bin_size).counts_so_far()
        is_enough = np.arange(1, len(drawn) + 1) >= self._enough[bins_so_far]
        count = int(is_enough.argmax()) + 1 if is_enough.any() else len(drawn)
        self.particles = drawn[:count]
        self.weights = np.full(count, 1.0 / count)

    def _draw(self, count: int) -> FloatArray:
        cumulative = np.cumsum(self.weights)
        chosen = np.searchsorted(cumulative, self.rng.uniform(0.0, cumulative[-1], count), side="right")
        drawn = self.particles[np.minimum(chosen, len(self.particles) - 1)]
        share = max(0.0, 1.0 - self._fast_average / self._slow_average)
        if share > 0.0:
            is_random = self.rng.random(count) < share
            drawn[is_random] = self._random_poses(int(is_random.sum()))
            # As the node does, lest ever more particles become random.
            self._slow_average = self._fast_average = 0.0
        return drawn

    def _mean_of_heaviest_cluster(self) -> FloatArray:
        clusters = ParticleBins(self.particles, self._bin_size).clusters()
        heaviest = clusters == np.bincount(clusters, weights=self.weights).argmax()
        return mean_pose(self.particles[heaviest], self.weights[heaviest])
