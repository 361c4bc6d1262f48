"""A number that identifies a physical state to the last bit."""

import zlib


def state_digest(positions: bytes, velocities: bytes) -> int:
    """CRC-32 of the bytes of qpos and qvel: two runs with the same digests have been equal bit by bit."""
    return zlib.crc32(velocities, zlib.crc32(positions))
