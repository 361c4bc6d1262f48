"""Unpacks the compressed parts of recordings, which may come from anywhere, up to a size."""

import zlib

import zstandard
from mcap.exceptions import McapError
from mcap.records import Chunk, McapRecord
from mcap.stream_reader import breakup_chunk

LARGEST_CHUNK = 2**28  # bytes; a whole recording is one chunk, with pictures some tens of MB
LARGEST_CONFIG = 10**6  # bytes
_LZ4_MAX_RATIO = 255

# Tells zlib to expect a gzip header.
_GZIP = 16 + zlib.MAX_WBITS


def unpack_chunk(chunk: Chunk) -> list[McapRecord]:
    """A chunk's records.

    Raises:
        McapError: it would unpack to more than LARGEST_CHUNK.
        ZstdError, ValueError: it is damaged.
    """
    size = chunk.uncompressed_size
    if chunk.compression == "zstd":  # its header gives the size that would be allocated
        size = max(size, zstandard.frame_content_size(chunk.data))
    elif chunk.compression == "lz4":
        size = max(size, _LZ4_MAX_RATIO * len(chunk.data))
    if size > LARGEST_CHUNK:
        raise McapError(f"a chunk that unpacks to {size} bytes")
    return breakup_chunk(chunk, validate_crc=True)


def unpack_config(data: bytes) -> str:
    """The text of a configuration.

    Raises:
        zlib.error, ValueError: it is damaged, or longer than LARGEST_CONFIG.
        EOFError: it ends too early.
    """
    unpacker = zlib.decompressobj(_GZIP)
    text = unpacker.decompress(data, LARGEST_CONFIG)
    if unpacker.unconsumed_tail:
        raise ValueError(f"a configuration of more than {LARGEST_CONFIG} bytes")
    if not unpacker.eof:
        raise EOFError("its configuration ends too early")
    return text.decode()
