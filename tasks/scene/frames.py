"""The bodies of a scene that can move, as frames relative to their parents' frames."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
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
        anchored: indices of the frames whose position in their parent cannot change, (k,).
        offsets: these positions, (k, 3) metres, as in the file: computed anew they would differ in the last bits.
        rigid: indices of the frames that cannot turn in their parent, (l,).
        turns: their rotations, as quaternions w, x, y, z, (l, 4).
    """

    frames: tuple[Frame, ...]
    num_bodies: int
    bodies: IntArray
    parents: IntArray
    anchored: IntArray
    offsets: FloatArray
    rigid: IntArray
    turns: FloatArray

    @classmethod
    def from_model(cls, model: mujoco.MjModel) -> Self:
        """Find the frames of a scene."""
        bodies = [body for body in range(1, model.nbody) if moves(model, body)]
        place = {body: index for index, body in enumerate(bodies)}
        parents = [place.get(int(model.body_parentid[body])) for body in bodies]
        names = [body_name(model, body) for body in bodies]
        inner = [index for index, parent in enumerate(parents) if parent is not None]
        anchored = [index for index in inner if _keeps_its_offset(model, bodies[index])]
        rigid = [index for index in inner if not model.body_jntnum[bodies[index]]]
        return cls(
            frames=tuple(
                Frame(name, WORLD if parent is None else names[parent])
                for name, parent in zip(names, parents, strict=True)
            ),
            num_bodies=int(model.nbody),
            bodies=np.array(bodies),
            parents=np.array([0 if parent is None else bodies[parent] for parent in parents]),
            anchored=np.array(anchored, dtype=int),
            offsets=model.body_pos[[bodies[index] for index in anchored]],
            rigid=np.array(rigid, dtype=int),
            turns=model.body_quat[[bodies[index] for index in rigid]],
        )

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
        places = np.empty((m, len(self.bodies), 7))
        places[..., :3], places[..., 3:] = positions[:, self.bodies], quaternions[:, self.bodies]  # as in the world
        if (frames := self._shifted).size:
            parents = self.parents[frames]
            offsets = places[:, frames, :3] - positions[:, parents]
            places[:, frames, :3] = _turned(offsets, quaternions[:, parents] * _CONJUGATE)
        if (frames := self._turning).size:
            inverse = quaternions[:, self.parents[frames]] * _CONJUGATE
            places[:, frames, 3:] = _product(inverse, places[:, frames, 3:])
        places[:, self.anchored, :3] = self.offsets
        places[:, self.rigid, 3:] = self.turns
        return places

    @cached_property
    def _shifted(self) -> IntArray:
        """Frames whose position in a moving parent can change."""
        return np.setdiff1d(np.flatnonzero(self.parents), self.anchored)

    @cached_property
    def _turning(self) -> IntArray:
        """Frames that can turn in a moving parent."""
        return np.setdiff1d(np.flatnonzero(self.parents), self.rigid)


def _keeps_its_offset(model: mujoco.MjModel, body: int) -> bool:
    """Whether a body only turns about its own origin within its parent."""
    first = int(model.body_jntadr[body])
    joints = range(first, first + int(model.body_jntnum[body]))
    turning = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_BALL))
    return all(int(model.jnt_type[joint]) in turning and not model.jnt_pos[joint].any() for joint in joints)


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Products of quaternions w, x, y, z, each (..., 4)."""
    product: FloatArray = ((a[..., None, :] @ _TABLE).reshape(*a.shape, 4) @ b[..., None])[..., 0]
    return product


def _turned(vectors: FloatArray, quaternions: FloatArray) -> FloatArray:
    """Vectors (..., 3) turned by unit quaternions (..., 4): q v q*."""
    as_quaternions = np.concatenate((np.zeros_like(vectors[..., :1]), vectors), axis=-1)
    return _product(_product(quaternions, as_quaternions), quaternions * _CONJUGATE)[..., 1:]
