"""Where the bodies of a scene are: each that can move as a frame, relative to the frame it hangs on."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from tasks.physics import FloatArray
from tasks.scene_parts import WORLD, body_name, moves

_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])
# Hamilton's table: component r of a product a·b is Σ a[p] b[q] over the p and q whose units give the unit r.
_TABLE: FloatArray = np.zeros((4, 4, 4))  # p, r, q
for _p, _row in enumerate(((1, 2, 3, 4), (2, -1, 4, -3), (3, -4, -1, 2), (4, 3, -2, -1))):
    for _q, _unit in enumerate(_row):
        _TABLE[_p, abs(_unit) - 1, _q] = np.sign(_unit)
_TABLE = _TABLE.reshape(4, 16)


@dataclass(frozen=True)
class Frame:
    """A frame's name and that of the one it is given in."""

    name: str
    parent: str


class BodyFrames:
    """Frames of all bodies that can move: the robot's, the goal's, those of things that may be pushed."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Find them."""
        bodies = [body for body in range(1, model.nbody) if moves(model, body)]
        place = {body: index for index, body in enumerate(bodies)}
        parents = [place.get(int(model.body_parentid[body])) for body in bodies]
        names = [body_name(model, body) for body in bodies]
        self.frames = [
            Frame(name, WORLD if parent is None else names[parent]) for name, parent in zip(names, parents, strict=True)
        ]
        self._num_bodies = int(model.nbody)
        self._bodies = np.array(bodies)
        self._parents = np.array([0 if parent is None else bodies[parent] for parent in parents])  # 0 is the world
        inner = [index for index, parent in enumerate(parents) if parent is not None]
        # What cannot change is given as the file has it: worked out anew it would differ in the last digits.
        self._anchored = [index for index in inner if _keeps_its_offset(model, bodies[index])]
        self._rigid = [index for index in inner if not model.body_jntnum[bodies[index]]]
        self._offsets = model.body_pos[[bodies[index] for index in self._anchored]]
        self._turns = model.body_quat[[bodies[index] for index in self._rigid]]
        self._all_anchored = len(self._anchored) == len(inner)

    def sample(self, data: mujoco.MjData) -> bytes:
        """Where all bodies of the scene are: what relative() takes; bytes are had in a third of an array's time."""
        return bytes(data.xpos.tobytes() + data.xquat.tobytes())

    def relative(self, samples: Sequence[bytes]) -> FloatArray:
        """Of m samples, each frame in its parent's: (m, n, 7), x, y, z in metres and the quaternion w, x, y, z."""
        m, n = len(samples), self._num_bodies
        numbers = np.frombuffer(b"".join(samples)).reshape(m, 7 * n)
        positions, quaternions = numbers[:, : 3 * n].reshape(m, n, 3), numbers[:, 3 * n :].reshape(m, n, 4)
        inverse = quaternions[:, self._parents] * _CONJUGATE
        places = np.empty((m, len(self._bodies), 7))
        if self._all_anchored:
            places[..., :3] = positions[:, self._bodies]
        else:
            places[..., :3] = _turned(positions[:, self._bodies] - positions[:, self._parents], inverse)
        places[..., 3:] = _product(inverse, quaternions[:, self._bodies])
        places[:, self._anchored, :3] = self._offsets
        places[:, self._rigid, 3:] = self._turns
        return places


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
