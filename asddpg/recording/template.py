"""Messages of one kind as bytes: numbers are filled into a template, a whole batch at once.

foxglove's objects encode one message in the template's making; after that nothing is made anew but the numbers, which
takes a fifth of the time. It holds for messages whose length does not change: every number is a double other than 0,
which protobuf would leave out, and times are written with all their digits.
"""

import struct
from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt
from foxglove.messages import Timestamp

from asddpg.recording.moments import NANOSECONDS
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
    """Fills times and numbers into copies of a message."""

    def __init__(self, make: Callable[[Timestamp, Numbers], Encodable], count: int) -> None:
        """Take the encoding of one message.

        Args:
            make: gives the message of a time and of `count` numbers.
            count: how many numbers there are.
        """
        stand_ins = [_FIRST_NUMBER * (1 + index / 1024) for index in range(count)]
        encoded: bytes = make(Timestamp(sec=_SECONDS, nsec=_NANOSECONDS), stand_ins).encode()
        self._bytes = np.frombuffer(encoded, dtype=np.uint8)
        numbers = [encoded.index(struct.pack("<d", number)) for number in stand_ins]
        self._numbers = (np.array(numbers)[:, None] + np.arange(8)).ravel()
        self._seconds = _everywhere(encoded, _SECONDS)
        self._nanoseconds = _everywhere(encoded, _NANOSECONDS)

    def fill(self, times: Sequence[int], numbers: FloatArray) -> list[bytes]:
        """A message for each of m times.

        Args:
            times: m simulated ns.
            numbers: (m, count).
        """
        filled = np.empty((len(times), len(self._bytes)), dtype=np.uint8)
        filled[:] = self._bytes
        filled[:, self._numbers] = np.ascontiguousarray(numbers, dtype="<f8").view(np.uint8)
        seconds, nanoseconds = np.divmod(np.array(times), NANOSECONDS)
        filled[:, self._seconds] = _digits(seconds)
        filled[:, self._nanoseconds] = _digits(nanoseconds)
        length = len(self._bytes)
        whole = filled.tobytes()
        return [whole[begin : begin + length] for begin in range(0, len(whole), length)]


def _everywhere(encoded: bytes, value: int) -> npt.NDArray[np.int64]:
    """Where the digits of a time stand: (places, digits)."""
    digits = _digits(np.array([value])).tobytes()
    places = []
    place = encoded.find(digits)
    while place >= 0:
        places.append(place)
        place = encoded.find(digits, place + 1)
    return np.array(places)[:, None] + np.arange(_DIGITS)


def _digits(values: npt.NDArray[np.int64]) -> npt.NDArray[np.uint8]:
    """Varints of a fixed length, leading zeros written out: (m, 1, digits)."""
    digits: npt.NDArray[np.uint8] = ((values[:, None, None] >> _SHIFTS) & 127 | _CONTINUED).astype(np.uint8)
    return digits
