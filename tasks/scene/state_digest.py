"""A number that names a physical state to the last bit."""

import zlib

import mujoco


def state_digest(data: mujoco.MjData) -> int:
    """CRC-32 of all positions and velocities: two runs with the same digests have been the same, bit by bit."""
    return digest_of(data.qpos.tobytes(), data.qvel.tobytes())


def digest_of(positions: bytes, velocities: bytes) -> int:
    """The same, of the bytes of qpos and qvel."""
    return zlib.crc32(velocities, zlib.crc32(positions))
