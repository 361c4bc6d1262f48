"""What is whole in an MCAP file that was cut off or damaged."""

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import IO, NamedTuple, cast

import zstandard
from mcap.opcode import Opcode
from mcap.records import Chunk, McapRecord
from mcap.stream_reader import StreamReader

from asddpg.recording.files.chunks import LARGEST_CHUNK, records_in
from asddpg.recording.files.reading import DAMAGE
from asddpg.recording.files.whole_reads import WholeReads

_RECORD = struct.Struct("<BQ")  # opcode, length
_CHUNK = struct.Struct("<QQQII")  # first and last time, size and CRC of the content, length of the compression's name
_LENGTH = struct.Struct("<Q")
_PIECE = 1024  # bytes that are decompressed at once; what follows a damaged one is lost


class Salvaged(NamedTuple):
    """What was found.

    Attributes:
        records: those of the data in their order, chunks unpacked, up to the first damage.
        damage: what it is; empty for a whole file.
    """

    records: list[McapRecord]
    damage: str


def salvage(path: Path) -> Salvaged:
    """Everything up to the first damage.

    Raises:
        OSError: the file cannot be read.
    """
    records: list[McapRecord] = []
    with path.open("rb") as file:
        begin = 0
        stream = StreamReader(cast(IO[bytes], WholeReads(file)), emit_chunks=True, validate_crcs=True)
        try:
            for record in stream.records:
                records += records_in(record) if isinstance(record, Chunk) else [record]
                begin = file.tell()
        except DAMAGE as error:
            file.seek(begin)
            records += _records_in(_beginning_of_chunk(file.read()))
            return Salvaged(records, " ".join(str(error).split()) or "it ends too early")
    return Salvaged(records, "")


def _records_in(data: bytes) -> Iterator[McapRecord]:
    try:
        yield from StreamReader(cast(IO[bytes], WholeReads(BytesIO(data))), skip_magic=True).records
    except DAMAGE:
        return


def _beginning_of_chunk(rest: bytes) -> bytes:
    """What can be unpacked of a chunk that does not end, or is damaged.

    Args:
        rest: of the file, from where the chunk begins.
    """
    head = _RECORD.size + _CHUNK.size
    if len(rest) < head or rest[0] != Opcode.CHUNK:
        return b""
    _, _, size, crc, name_length = _CHUNK.unpack_from(rest, _RECORD.size)
    begin = head + name_length + _LENGTH.size
    if len(rest) < begin:
        return b""
    compression = rest[head : head + name_length]
    (length,) = _LENGTH.unpack_from(rest, begin - _LENGTH.size)
    data = rest[begin : begin + length]
    content = _decompressed(data) if compression == b"zstd" else data if not compression else b""
    # With all of it there and the sum wrong, nobody knows which of it is.
    is_wrong = len(content) == size and crc != 0 and zlib.crc32(content) != crc
    return b"" if is_wrong else content


def _decompressed(data: bytes) -> bytes:
    """The beginning, up to where it is damaged or ends."""
    decompressor = zstandard.ZstdDecompressor().decompressobj()
    content = bytearray()
    try:
        for begin in range(0, len(data), _PIECE):
            content += decompressor.decompress(data[begin : begin + _PIECE])
            if len(content) > LARGEST_CHUNK:
                return b""
    except zstandard.ZstdError:
        pass
    return bytes(content)
