"""Poses of frames within one another."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from tasks.physics import FloatArray
from tasks.rooms.room import Quaternion, Vector


@dataclass(frozen=True)
class Transform:
    """From a frame into the one it lies in.

    Attributes:
        rotation: (3, 3).
        translation: (3,), metres.
    """

    rotation: FloatArray
    translation: FloatArray

    @classmethod
    def from_rpy(cls, position: Sequence[float], rpy: Sequence[float]) -> "Transform":
        """From a position (m) and roll, pitch and yaw (rad) about the fixed axes x, y and z."""
        quaternion = np.empty(4)
        mujoco.mju_euler2Quat(quaternion, np.array(rpy), "XYZ")
        return cls.from_quaternion(position, quaternion.tolist())

    @classmethod
    def from_quaternion(cls, position: Sequence[float], wxyz: Sequence[float]) -> "Transform":
        """From a position (m) and a quaternion w, x, y, z of any length but 0."""
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, np.array(wxyz) / np.linalg.norm(wxyz))
        return cls(rotation.reshape(3, 3), np.array(position, dtype=np.float64))

    def __matmul__(self, inner: "Transform") -> "Transform":
        """The pose of a frame within the inner one's outer frame."""
        return Transform(self.rotation @ inner.rotation, self.apply(inner.translation))

    def apply(self, points: FloatArray) -> FloatArray:
        """Points (..., 3) of the inner frame in the outer one, metres."""
        return points @ self.rotation.T + self.translation

    def inverse(self) -> "Transform":
        """From the outer frame into the inner one."""
        return Transform(self.rotation.T, -self.translation @ self.rotation)

    @property
    def position(self) -> Vector:
        """Of the origin, metres."""
        x, y, z = self.translation.tolist()
        return x, y, z

    @property
    def quaternion(self) -> Quaternion:
        """w, x, y, z."""
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, self.rotation.ravel())
        w, x, y, z = quaternion.tolist()
        return w, x, y, z


IDENTITY = Transform(np.eye(3), np.zeros(3))
