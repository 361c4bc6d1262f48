"""Writes a recording: `<stem>.mcap.part` while its episode goes on, `<stem>_<outcome>.mcap` when it is complete.

Both take the same messages. The part is on the disk after every batch, so that any MCAP reader finds all but the last
batch after the process was killed; only the summary is missing. It is neither chunked nor compressed, which costs less;
the complete file, which is both, is made in memory and written at the end.
"""

import contextlib
import gzip
import io
from collections.abc import Mapping
from pathlib import Path
from typing import IO

import foxglove
from foxglove.mcap import MCAPWriteOptions

METADATA = "asddpg"  # name of the metadata record
CONFIG = "config.yaml.gz"  # name of the attachment
MCAP, PART = ".mcap", ".part"

# Without all that only a summary needs.
_IN_PROGRESS = MCAPWriteOptions(
    use_chunks=False,
    compression=None,
    emit_statistics=False,
    repeat_channels=False,
    repeat_schemas=False,
    calculate_data_section_crc=False,
)
# Chunks of some 80 steps: smaller ones take more disk space, larger ones lose more where a file is damaged. A higher
# level makes files of this size no smaller.
_COMPLETE = MCAPWriteOptions(chunk_size=200_000, compression_level=1, compression_threads=0, emit_summary_offsets=False)


def pack_config(config: str) -> bytes:
    """A configuration, YAML, as it is attached: MCAP does not compress attachments."""
    return gzip.compress(config.encode(), mtime=0)


class RecordingFile:
    """Takes the messages that are logged on a context until it is completed or dropped."""

    def __init__(
        self, folder: Path, stem: str, context: foxglove.Context, metadata: Mapping[str, str], config: bytes
    ) -> None:
        """Begin a recording; files are made later.

        Args:
            folder: where they go.
            stem: their name without endings.
            context: whose messages they take.
            metadata: of the recording.
            config: the configuration, packed.
        """
        self._folder, self._stem = folder, stem
        self._part, self._new = folder / f"{stem}{MCAP}{PART}", folder / f"{stem}{MCAP}.new"
        self._part_content, self._content = io.BytesIO(), io.BytesIO()
        self._part_writer, self._writer = (
            foxglove.open_mcap(content, context=context, writer_options=options)
            for content, options in ((self._part_content, _IN_PROGRESS), (self._content, _COMPLETE))
        )
        for writer in (self._part_writer, self._writer):
            writer.write_metadata(METADATA, dict(metadata))
            writer.attach(create_time=0, log_time=0, name=CONFIG, media_type="application/gzip", data=config)
        self._part_file: IO[bytes] | None = None
        self._written = 0  # bytes of the part

    def flush(self) -> None:
        """Append what was logged since the last time to the part.

        Raises:
            OSError: it could not be written.
        """
        self._part_writer.flush()
        if self._part_file is None:
            self._make_folder()
            self._part_file = self._part.open("wb")
        self._part_file.write(self._part_content.getbuffer()[self._written :])
        self._part_file.flush()
        self._written = self._part_content.tell()

    def complete(self, outcome: str) -> Path:
        """Put the whole file in the place of the part; returns its path.

        Raises:
            OSError: it could not be written.
        """
        self._writer.close()
        self._make_folder()
        self._new.write_bytes(self._content.getbuffer())
        path = self._new.rename(self._folder / f"{self._stem}_{outcome}{MCAP}")
        self.drop()
        return path

    def _make_folder(self) -> None:
        if not self._folder.is_dir():  # which costs a twentieth of mkdir
            self._folder.mkdir(parents=True, exist_ok=True)

    def drop(self) -> None:
        """End the recording and delete what is not complete."""
        for writer in (self._part_writer, self._writer):
            writer.close()
        if self._part_file is not None:
            with contextlib.suppress(OSError):
                self._part_file.close()
        for path in (self._part, self._new):
            with contextlib.suppress(OSError):
                path.unlink()
