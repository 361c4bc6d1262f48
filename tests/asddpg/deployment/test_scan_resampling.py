"""A scan of any laser with the beams of a policy's."""

import math

import numpy as np
import pytest

from asddpg.deployment.scan_resampling import ScanResampler
from asddpg.errors import UserError
from tasks.laser import LaserConfig

OWN = LaserConfig()  # 40 beams over 240°, up to 5.6 m


def linear(angles: np.ndarray) -> np.ndarray:
    """A range for each direction, in which every beam differs."""
    return np.asarray(2.0 + (angles + math.pi) % (2 * math.pi) / 4.0)


def test_its_own_scan_stays_as_it_is_to_the_last_bit() -> None:
    ranges = np.random.default_rng(0).uniform(0.02, 5.6, 40)
    np.testing.assert_array_equal(ScanResampler(OWN).resample(ranges, OWN.angles()), ranges)


@pytest.mark.parametrize(
    "angles",
    [
        np.radians(np.linspace(-135, 135, 1081)),
        np.radians(np.arange(360)),  # from 0 to 359°
        np.radians(np.arange(360))[::-1],  # clockwise
        np.random.default_rng(1).permutation(np.radians(np.linspace(-180, 180, 720))),
        np.radians(np.linspace(-119.885, 119.885, 682)),  # a real URG-04LX's
    ],
)
def test_beams_are_taken_by_their_angle(angles: np.ndarray) -> None:
    found = ScanResampler(OWN).resample(linear(angles), angles)
    np.testing.assert_allclose(found, linear(OWN.angles()), atol=math.radians(0.6) / 4)


def test_a_coarser_scan_gives_the_nearest_beam() -> None:
    angles = np.radians([-120, -110, -100, *range(-90, 121, 10)])
    found = ScanResampler(OWN).resample(linear(angles), angles)
    np.testing.assert_allclose(found, linear(OWN.angles()), atol=math.radians(5.1) / 4)


@pytest.mark.parametrize(
    ("angles", "sentence"),
    [
        (np.radians(np.linspace(-90, 90, 181)), "lacks 8 of the policy's 40 beams, the first at -120°"),
        (np.radians(np.arange(-120, 110)), "lacks 1 of the policy's 40 beams, the first at 120°"),
        (np.radians([-120, -60, 0, 60, 120]), "needs beams over 240°, within 6.2° of its own"),
        (np.radians([*range(-180, 20), *range(40, 181)]), "the first at 28°"),
        ([], "needs beams over 240°"),
    ],
)
def test_a_scan_without_the_policys_beams_is_refused(angles: np.ndarray, sentence: str) -> None:
    with pytest.raises(UserError, match=sentence):
        ScanResampler(OWN).resample(np.ones(len(angles)), angles)


def test_what_is_no_range_is_read_by_rep_117() -> None:
    angles, ranges = OWN.angles(), np.full(40, 2.0)
    ranges[[5, 10]] = math.inf, -math.inf
    ranges[[15, 20]] = 9.0, 0.001
    found = ScanResampler(OWN).resample(ranges, angles)
    assert found[[5, 10, 15, 20]].tolist() == [5.6, 0.02, 5.6, 0.02]


@pytest.mark.parametrize("invalid", [math.nan, 0.0, -1.0])
def test_an_invalid_beam_reads_its_nearest_valid_neighbour_or_nothing(invalid: float) -> None:
    angles = np.radians(np.linspace(-135, 135, 1081))
    ranges = np.full(1081, 3.0)
    ranges[538:543] = invalid  # 1.25° about 0°
    assert (ScanResampler(OWN).resample(ranges, angles) == 3.0).all()
    ranges[angles > math.radians(90.0)] = invalid  # a quarter
    found = ScanResampler(OWN).resample(ranges, angles)
    assert (found[OWN.angles() < math.radians(90.0)] == 3.0).all()
    assert (found[OWN.angles() > math.radians(97.0)] == 5.6).all()


@pytest.mark.parametrize(
    ("ranges", "angles", "sentence"),
    [
        (np.full(40, math.nan), OWN.angles(), "none of the scan's 40 beams is valid"),
        (np.ones(39), OWN.angles(), "a range and a finite angle"),
        (np.ones(40), np.full(40, math.nan), "a range and a finite angle"),
        (np.ones((1, 40)), OWN.angles()[None], "a range and a finite angle"),
    ],
)
def test_what_is_no_scan_is_refused(ranges: np.ndarray, angles: np.ndarray, sentence: str) -> None:
    with pytest.raises(UserError, match=sentence):
        ScanResampler(OWN).resample(ranges, angles)


def test_another_laser_may_follow() -> None:
    resampler = ScanResampler(OWN)
    for angles in (OWN.angles(), np.radians(np.arange(360)), OWN.angles()):
        np.testing.assert_allclose(resampler.resample(linear(angles), angles), linear(OWN.angles()), atol=0.01)


def test_a_beam_of_several_rays_reads_the_nearest_return_of_them() -> None:
    laser, angles = LaserConfig(rays_per_beam=5), np.radians(np.arange(360))
    ranges = np.full(360, 3.0)
    ranges[1] = 1.0  # a thin leg at 1°, between the middles of two beams
    found = ScanResampler(laser).resample(ranges, angles)
    assert found.tolist() == [1.0 if index == 20 else 3.0 for index in range(40)]


def test_a_scan_of_as_many_beams_as_the_policys_is_enough_for_its_rays() -> None:
    laser = LaserConfig(rays_per_beam=5)
    found = ScanResampler(laser).resample(np.arange(1.0, 41.0) / 10, laser.angles())
    assert (found == np.arange(1.0, 41.0) / 10).all()
