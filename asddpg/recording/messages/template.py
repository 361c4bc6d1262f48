"""Messages that are told together, as bytes: numbers are filled into a template, a whole batch at once.

foxglove's objects encode one message of each kind in the template's making; after that nothing is made anew but the
numbers, which takes a tenth of the time. It holds for messages whose length does not change: every number is a double
that is written even where it is 0, which protobuf would leave out, and times are written with all their digits.
"""

import itertools
import struct
from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt
from foxglove.messages import Timestamp

from asddpg.recording.samples import NANOSECONDS
from tasks.physics import FloatArray

Numbers = Sequence[float]

_DIGITS = 5  # bytes of a varint below 2^35
_SHIFTS = 7 * np.arange(_DIGITS)
_CONTINUED = np.array([128] * (_DIGITS - 1) + [0])
# Stand-ins, found again in the encoded message: a time whose seconds and nanoseconds take 5 bytes each, and doubles
# that nothing else holds.
_SECONDS, _NANOSECONDS = 4_294_967_291, 999_999_937
_FIRST_NUMBER = 1.2345e200


class Encodable(Protocol):
    """A message of foxglove's."""

    def encode(self) -> bytes:
        """In protobuf's wire format."""


class Template:
    """Fills times and numbers into copies of some messages."""

    def __init__(self, make: Callable[[Timestamp, Numbers], Sequence[Encodable]], count: int) -> None:
        """Take the encoding of messages.

        Args:
            make: gives the messages of a time and of `count` numbers.
            count: how many numbers there are.
        """
        stand_ins = [_FIRST_NUMBER * (1 + index / 1024) for index in range(count)]
        messages = [each.encode() for each in make(Timestamp(sec=_SECONDS, nsec=_NANOSECONDS), stand_ins)]
        encoded = b"".join(messages)
        self._bytes = np.frombuffer(encoded, dtype=np.uint8)
        ends = list(itertools.accumulate(map(len, messages)))
        self._messages = [slice(*bounds) for bounds in itertools.pairwise([0, *ends])]
        self._numbers = np.array([encoded.index(struct.pack("<d", number)) for number in stand_ins])
        # Where the digits of seconds and nanoseconds stand: (places, 2, digits).
        self._stamps = np.stack((_everywhere(encoded, _SECONDS), _everywhere(encoded, _NANOSECONDS)), axis=1)

    def fill(self, times: Sequence[int], numbers: FloatArray) -> list[list[bytes]]:
        """The messages of each of m times.

        Args:
            times: m simulated ns.
            numbers: (m, count).
        """
        length = len(self._bytes)
        filled = np.empty((len(times), length), dtype=np.uint8)
        filled[:] = self._bytes
        # A double at every byte: [moment, where it begins].
        doubles = np.ndarray((len(times), length - 7), dtype="<f8", buffer=filled, strides=(length, 1))
        doubles[:, self._numbers] = numbers
        filled[:, self._stamps] = _digits(np.stack(np.divmod(times, NANOSECONDS), axis=-1))[:, None]
        rows = (row.tobytes() for row in filled)
        return [[row[message] for message in self._messages] for row in rows]


def _everywhere(encoded: bytes, value: int) -> npt.NDArray[np.int64]:
    """Where the digits of a time stand: (places, digits)."""
    digits = _digits(np.array(value)).tobytes()
    places = []
    place = encoded.find(digits)
    while place >= 0:
        places.append(place)
        place = encoded.find(digits, place + 1)
    return np.array(places)[:, None] + np.arange(_DIGITS)


def _digits(values: npt.NDArray[np.int64]) -> npt.NDArray[np.uint8]:
    """Varints of a fixed length, leading zeros written out: (…, digits)."""
    digits: npt.NDArray[np.uint8] = ((values[..., None] >> _SHIFTS) & 127 | _CONTINUED).astype(np.uint8)
    return digits
