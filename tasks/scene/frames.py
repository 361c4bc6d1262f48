"""The bodies of a scene that can move, as frames relative to their parents' frames."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import mujoco
import numpy as np
import numpy.typing as npt

from tasks.physics import FloatArray
from tasks.scene.shapes import WORLD, body_name, moves

IntArray = npt.NDArray[np.int64]

_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])
# Hamilton's table: component r of a product a·b is Σ a[p] b[q] over the p and q whose units give the unit r.
_TABLE: FloatArray = np.zeros((4, 4, 4))  # p, r, q
for _p, _row in enumerate(((1, 2, 3, 4), (2, -1, 4, -3), (3, -4, -1, 2), (4, 3, -2, -1))):
    for _q, _unit in enumerate(_row):
        _TABLE[_p, abs(_unit) - 1, _q] = np.sign(_unit)
_TABLE = _TABLE.reshape(4, 16)


@dataclass(frozen=True)
class Frame:
    """Names of a frame and of its parent."""

    name: str
    parent: str


@dataclass(frozen=True)
class BodyFrames:
    """Frames of all bodies that can move: of the robot, the goal and the movable things.

    Attributes:
        frames: by name.
        num_bodies: of the scene, the world among them.
        bodies: number of each frame's body, (n,).
        parents: number of each frame's parent body, 0 for the world, (n,).
    """

    frames: tuple[Frame, ...]
    num_bodies: int
    bodies: IntArray
    parents: IntArray

    @classmethod
    def from_model(cls, model: mujoco.MjModel) -> Self:
        """Find the frames of a scene."""
        bodies = [body for body in range(1, model.nbody) if moves(model, body)]
        parents = [parent if (parent := int(model.body_parentid[body])) in bodies else 0 for body in bodies]
        names = {0: WORLD} | {body: body_name(model, body) for body in bodies}
        frames = (Frame(names[body], names[parent]) for body, parent in zip(bodies, parents, strict=True))
        return cls(tuple(frames), int(model.nbody), np.array(bodies), np.array(parents))

    def index(self, name: str) -> int:
        """Index of the frame of a name."""
        return [frame.name for frame in self.frames].index(name)

    def relative(self, samples: Sequence[bytes]) -> FloatArray:
        """Pose of each frame in its parent, at m instants: (m, n, 7), x, y, z in metres and the quaternion w, x, y, z.

        Args:
            samples: poses of all bodies of the scene in the world: bytes of xpos, then of xquat.
        """
        m, n = len(samples), self.num_bodies
        numbers = np.frombuffer(b"".join(samples)).reshape(m, 7 * n)
        positions, quaternions = numbers[:, : 3 * n].reshape(m, n, 3), numbers[:, 3 * n :].reshape(m, n, 4)
        to_parent = quaternions[:, self.parents] * _CONJUGATE
        both = np.zeros((2, m, len(self.bodies), 4))  # offsets, as quaternions with w = 0, and rotations
        both[0, ..., 1:] = positions[:, self.bodies] - positions[:, self.parents]
        both[1] = quaternions[:, self.bodies]
        offsets, turns = _product(to_parent, both)
        return np.concatenate((_product(offsets, to_parent * _CONJUGATE)[..., 1:], turns), axis=-1)


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Products of quaternions w, x, y, z, each (..., 4)."""
    product: FloatArray = ((a @ _TABLE).reshape(*a.shape, 4) @ b[..., None])[..., 0]
    return product
