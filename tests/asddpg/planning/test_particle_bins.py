"""Bins of particles: the number that a belief needs, and its clusters."""

import numpy as np
import pytest

from asddpg.planning.particle_bins import BinSize, ParticleBins, kld_number

DEGREE = np.pi / 180


def test_number_of_particles_by_hand() -> None:
    # Ten bins: 2/(9·9) = 0.0246914, its root 0.1571348; 9/0.02 · (1 − 0.0246914 + 0.1555634)³ = 450 · 1.446245 = 650.8
    # Two bins: 2/9, its root 0.4714045; 1/0.02 · (1 − 0.2222222 + 0.4666905)³ = 50 · 1.927229 = 96.4
    assert kld_number([10, 2, 1], 0.01, 0.99).tolist() == [651, 97, 0]
    # A twentieth to be tolerated, at 99 percent: 2.3263479 · 0.1571348 = 0.3655503; 90 · 1.3408589³ = 216.97
    assert kld_number(10, 0.05, 2.3263479) == 217


def test_bins_are_counted_as_particles_come() -> None:
    particles = np.array([(0.1, 0.1, 0.1), (0.4, 0.4, 0.1), (0.6, 0.1, 0.1), (0.2, 0.2, 0.1), (0.6, 0.1, -0.1)])
    bins = ParticleBins(particles, BinSize(0.5, 10 * DEGREE))
    assert bins.counts_so_far().tolist() == [1, 1, 2, 2, 3]
    assert bins.count == 3
    assert bins.of_particle[0] == bins.of_particle[1] == bins.of_particle[3] != bins.of_particle[2]


@pytest.mark.parametrize(
    ("other", "together"),
    [
        ((0.7, 0.2, 0.0), True),
        ((0.7, 0.7, 12 * DEGREE), True),  # across a corner
        ((-0.2, 0.7, -8 * DEGREE), True),
        ((1.2, 0.2, 0.0), False),
        ((0.2, -0.7, 0.0), False),
        ((0.2, 0.2, 25 * DEGREE), False),
    ],
)
def test_bins_that_touch_are_one_cluster(other: tuple[float, float, float], together: bool) -> None:
    clusters = ParticleBins(np.array([(0.2, 0.2, 2 * DEGREE), other]), BinSize(0.5, 10 * DEGREE)).clusters()
    assert (clusters[0] == clusters[1]) == together


def test_yaw_is_a_circle_and_clusters_are_chains() -> None:
    yaws = np.array([-175, 175, 165, 155, 0, 8]) * DEGREE
    particles = np.stack((np.full(6, -3.2), np.full(6, 100.1), yaws), axis=-1)
    clusters = ParticleBins(particles, BinSize(0.5, 10 * DEGREE)).clusters()
    assert len({*clusters[:4].tolist()}) == len({*clusters[4:].tolist()}) == 1
    assert clusters[0] != clusters[4]


@pytest.mark.parametrize(
    "particles",
    [[(0.2, 4.7, 0.0), (0.7, 0.2, 0.0)], [(0.2, 0.2, 175 * DEGREE), (0.2, 1.2, -175 * DEGREE)]],
    ids=["rows", "yaw"],
)
def test_far_ends_of_an_axis_do_not_touch(particles: list[tuple[float, float, float]]) -> None:
    assert np.unique(ParticleBins(np.array(particles), BinSize()).clusters()).size == 2
