"""/tf in protobuf's wire format: numbers are filled into a template, in a tenth of the time that message objects take.

What stands where: foxglove.FrameTransforms, https://docs.foxglove.dev/docs/sdk/schemas/frame-transforms, and
https://protobuf.dev/programming-guides/encoding. A viewer gets, after a jump in time, the last message of a topic
alone: so each message holds all frames.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from foxglove import Schema
from foxglove.messages import FrameTransforms

from tasks.body_frames import Frame
from tasks.physics import FloatArray

_VARINT, _DOUBLE, _BYTES = 0, 1, 2  # wire types
_TIME_BYTES = 5  # of a varint below 2^35, its leading zeros written out: all times then take the same room
_PLACE = ("x", "y", "z", "qw", "qx", "qy", "qz")


class TransformBytes:
    """Messages of all frames, each as bytes."""

    def __init__(self, frames: Sequence[Frame]) -> None:
        """Of frames with those names."""
        self.schema: Schema = FrameTransforms.get_schema()
        blocks = [_transform(frame) for frame in frames]
        self._template = np.frombuffer(b"".join(blocks), dtype=np.uint8)
        begins = np.cumsum([0, *(len(block) for block in blocks[:-1])])
        doubles, times = zip(*(_holes(block) for block in blocks), strict=True)
        # (n, 7) and (n,): where in the message each number begins.
        self._doubles = begins[:, None] + np.array(doubles)
        self._seconds, self._nanoseconds = (begins + np.array(column) for column in zip(*times, strict=True))

    def messages(self, places: FloatArray, times: Sequence[int]) -> list[bytes]:
        """A message for each time.

        Args:
            places: (m, n, 7), of each frame in its parent's x, y, z in metres and the quaternion w, x, y, z.
            times: m simulated ns.
        """
        buffer = np.tile(self._template, (len(times), 1))
        width = np.arange(8)
        numbers = np.ascontiguousarray(places, dtype="<f8").view(np.uint8).reshape(*places.shape, 8)
        buffer[:, self._doubles[..., None] + width] = numbers
        digits = np.arange(_TIME_BYTES)
        seconds, nanoseconds = np.divmod(np.array(times), 1_000_000_000)
        buffer[:, self._seconds[:, None] + digits] = _varints(seconds)[:, None]
        buffer[:, self._nanoseconds[:, None] + digits] = _varints(nanoseconds)[:, None]
        return [row.tobytes() for row in buffer]


def _transform(frame: Frame) -> bytes:
    """One frame as a field of FrameTransforms, with zeros for the numbers."""
    stamp = _tag(1, _VARINT) + _NO_TIME + _tag(2, _VARINT) + _NO_TIME
    offset = b"".join(_tag(number, _DOUBLE) + bytes(8) for number in (1, 2, 3))
    turn = b"".join(_tag(number, _DOUBLE) + bytes(8) for number in (1, 2, 3, 4))
    fields = (stamp, frame.parent.encode(), frame.name.encode(), offset, turn)
    return _field(1, b"".join(_field(number, field) for number, field in enumerate(fields, 1)))


def _holes(block: bytes) -> tuple[list[int], tuple[int, int]]:
    """Where in a block the numbers stand, in the order x, y, z, qw, qx, qy, qz, and seconds and nanoseconds."""
    turn = len(block) - 4 * 9
    offset = turn - 2 - 3 * 9
    stamp = block.index(_NO_TIME)
    x, y, z = (offset + 9 * index + 1 for index in range(3))
    qx, qy, qz, qw = (turn + 9 * index + 1 for index in range(4))
    return [x, y, z, qw, qx, qy, qz], (stamp, stamp + _TIME_BYTES + 1)


def _tag(number: int, kind: int) -> bytes:
    return bytes([number << 3 | kind])


def _field(number: int, content: bytes) -> bytes:
    return _tag(number, _BYTES) + _varint(len(content)) + content


def _varint(value: int) -> bytes:
    digits = []
    while value >= 128:
        digits.append(value & 127 | 128)
        value >>= 7
    return bytes([*digits, value])


_NO_TIME = bytes([128] * (_TIME_BYTES - 1) + [0])
_SHIFTS = 7 * np.arange(_TIME_BYTES)
_CONTINUED = np.array([128] * (_TIME_BYTES - 1) + [0])


def _varints(values: npt.NDArray[np.int64]) -> npt.NDArray[np.uint8]:
    digits: npt.NDArray[np.uint8] = ((values[:, None] >> _SHIFTS) & 127 | _CONTINUED).astype(np.uint8)
    return digits
