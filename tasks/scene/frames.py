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

# Hamilton's table for a*·b, a* the conjugate of a: component r is Σ a[p] b[q], with the table's sign, over the p and q
# whose units give the unit r. Components of a and b: w, x, y, z, those of the product: x, y, z, w.
_TABLE: FloatArray = np.zeros((4, 4, 4))  # p, r, q
for _p, _row in enumerate(((1, 2, 3, 4), (-2, 1, -4, 3), (-3, 4, 1, -2), (-4, -3, 2, 1))):
    for _q, _unit in enumerate(_row):
        _TABLE[_p, abs(_unit) - 2, _q] = np.sign(_unit)
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
        """Pose of each frame in its parent, at m instants: (m, n, 7), x, y, z in metres and the quaternion x, y, z, w.

        Args:
            samples: poses of all bodies of the scene in the world: bytes of xpos, then of xquat, then of xmat.
        """
        m, n = len(samples), self.num_bodies
        numbers = np.frombuffer(b"".join(samples)).reshape(m, 16 * n)
        positions, quaternions = numbers[:, : 3 * n].reshape(m, n, 3), numbers[:, 3 * n : 7 * n].reshape(m, n, 4)
        rotations = numbers[:, 7 * n :].reshape(m, n, 3, 3)
        offsets = positions[:, self.bodies] - positions[:, self.parents]
        turns = (quaternions[:, self.parents] @ _TABLE).reshape(m, -1, 4, 4)
        return np.concatenate(
            (
                (offsets[:, :, None] @ rotations[:, self.parents])[:, :, 0],
                (turns @ quaternions[:, self.bodies, :, None])[..., 0],
            ),
            axis=-1,
        )
