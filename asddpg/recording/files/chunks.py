"""Unpacks what is compressed in a recording, which a stranger may have made, up to a size."""

import zlib

import zstandard
from mcap.exceptions import McapError
from mcap.records import Chunk, McapRecord
from mcap.stream_reader import breakup_chunk

LARGEST_CHUNK = 2**28  # bytes; the writers here fill 1 MB, and a picture or a model more goes into none
LARGEST_CONFIG = 10**6  # bytes
_LZ4_AT_MOST = 255  # times its size

# Says that a gzip header comes first.
_GZIP = 16 + zlib.MAX_WBITS


def records_in(chunk: Chunk) -> list[McapRecord]:
    """A chunk's records.

    Raises:
        McapError: it unpacks to more than any recording's.
        ZstdError, ValueError: it is damaged.
    """
    size = chunk.uncompressed_size
    if chunk.compression == "zstd":  # the size in its header is what would be allocated
        size = max(size, zstandard.frame_content_size(chunk.data))
    elif chunk.compression == "lz4":
        size = max(size, _LZ4_AT_MOST * len(chunk.data))
    if size > LARGEST_CHUNK:
        raise McapError(f"a chunk that unpacks to {size} bytes")
    return breakup_chunk(chunk, validate_crc=True)


def unpacked_config(data: bytes) -> str:
    """The text of a configuration.

    Raises:
        zlib.error, ValueError: it is damaged, or longer than any.
        EOFError: it ends too early.
    """
    unpacker = zlib.decompressobj(_GZIP)
    text = unpacker.decompress(data, LARGEST_CONFIG)
    if unpacker.unconsumed_tail:
        raise ValueError(f"a configuration of more than {LARGEST_CONFIG} bytes")
    if not unpacker.eof:
        raise EOFError("its configuration ends too early")
    return text.decode()
