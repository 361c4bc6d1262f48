"""Poses in the plane, against cases worked out by hand."""

import numpy as np
import pytest

from asddpg.planning.poses import compose, mean_pose, pose_between, pose_covariance, wrap_angle


def test_angles_wrap_into_minus_pi_to_pi() -> None:
    np.testing.assert_allclose(
        wrap_angle([0.0, np.pi, 3.5 * np.pi, -1.25 * np.pi]), np.pi * np.array([0, -1, -0.5, 0.75])
    )


def test_a_motion_is_in_the_frame_of_each_pose() -> None:
    moved = compose([[1.0, 2.0, np.pi / 2], [0.0, 0.0, np.pi]], (1.0, 0.5, np.pi / 2))
    np.testing.assert_allclose(moved, [[0.5, 3.0, -np.pi], [-1.0, -0.5, -np.pi / 2]], atol=1e-12)


def test_the_pose_between_two_leads_from_one_to_the_other() -> None:
    before, after = (1.0, 2.0, np.pi / 2), (0.5, 3.0, -3.0)
    np.testing.assert_allclose(pose_between(before, after), (1.0, 0.5, 1.5 * np.pi - 3.0), atol=1e-12)
    np.testing.assert_allclose(compose(before, pose_between(before, after)), after)


def test_mean_and_covariance_where_yaw_wraps() -> None:
    poses = np.array([[0.0, 1.0, np.pi - 0.1], [1.0, 3.0, -np.pi + 0.1]])
    even, uneven = np.array([0.5, 0.5]), np.array([3.0, 1.0])
    center = mean_pose(poses, even)
    assert center[:2].tolist() == [0.5, 2.0]
    assert abs(center[2]) == pytest.approx(np.pi)
    assert mean_pose(poses, uneven)[:2].tolist() == [0.25, 1.5]
    expected = np.outer((0.5, 1.0, 0.1), (0.5, 1.0, 0.1))
    np.testing.assert_allclose(pose_covariance(poses, even, center), expected)
