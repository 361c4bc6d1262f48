"""Moments as bytes: what a recording in progress holds in the place of messages.

To tell each step while the episode goes on would take more than twice the time; the messages are made at its end, or by
whoever reads what a killed process has left. How the bytes are read is told by their channel itself: neither a scene
nor a configuration is needed.
"""

import dataclasses
import itertools
import json
import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import orjson

from asddpg.recording.samples import Moment
from tasks.scene.frames import BodyFrames, Frame

TOPIC, ENCODING = "/moments", "asddpg.moments"
_MOST_BEAMS = 100_000  # a stranger's file does not decide how much memory is taken
_LENGTH = struct.Struct("<I")


@dataclasses.dataclass(frozen=True)
class Layout:
    """What has to be known of a scene to tell moments of it.

    Attributes:
        frames: what can move.
        scan_shape: scans and beams at the head of an observation.
        is_video: whether cameras' pictures are H.264 and not JPEG.
    """

    frames: BodyFrames
    scan_shape: tuple[int, int]
    is_video: bool

    def as_text(self) -> dict[str, str]:
        """For a channel's metadata."""
        told = dataclasses.asdict(self)
        return {name: orjson.dumps(value, option=orjson.OPT_SERIALIZE_NUMPY).decode() for name, value in told.items()}

    @classmethod
    def of_text(cls, text: Mapping[str, str]) -> "Layout":
        """From a channel's metadata.

        Raises:
            LookupError, TypeError, ValueError: that is no layout.
        """
        told: dict[str, Any] = json.loads(text["frames"])
        arrays = {name: np.array(told[name], dtype=int) for name in ("bodies", "parents")}
        frames = tuple(Frame(**frame) for frame in told["frames"])
        num_scans, num_beams = map(int, json.loads(text["scan_shape"]))
        if not 0 <= num_beams <= _MOST_BEAMS:
            raise ValueError("a scan of a size that nobody records")
        return cls(
            BodyFrames(frames, num_bodies=int(told["num_bodies"]), **arrays),
            (num_scans, num_beams),
            bool(json.loads(text["is_video"])),
        )


def packed(moments: Sequence[Moment]) -> bytes:
    """A message of some moments."""
    heads: list[Any] = []
    pieces: list[Any] = []
    for number, time, driver, step, command, observation, positions, quaternions, pictures in moments:
        taken = pictures.values()
        sizes = [len(step), len(command), observation.nbytes, len(positions), len(quaternions), *map(len, taken)]
        heads.append((number, time, driver, sizes, list(pictures)))
        pieces += step, command, observation, positions, quaternions, *taken
    head = orjson.dumps(heads)
    return b"".join([_LENGTH.pack(len(head)), head, *pieces])


def unpacked(message: bytes) -> Iterator[Moment]:
    """Its moments.

    Raises:
        LookupError, TypeError, ValueError, struct.error: these are no moments.
    """
    (length,) = _LENGTH.unpack_from(message)
    begin = _LENGTH.size + length
    for number, time, driver, sizes, cameras in json.loads(message[_LENGTH.size : begin]):
        ends = list(itertools.accumulate(sizes, initial=begin))
        if ends[-1] > len(message) or ends != sorted(ends):
            raise ValueError("moments are cut off")
        step, command, observation, positions, quaternions, *pictures = (
            message[a:b] for a, b in itertools.pairwise(ends)
        )
        numbers = np.frombuffer(observation, dtype=np.float32)
        taken = dict(zip(cameras, pictures, strict=True))
        yield Moment(number, time, driver, step, command, numbers, positions, quaternions, taken)
        begin = ends[-1]
