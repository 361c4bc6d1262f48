"""A recording's file: plain and up to date while its episode goes on, compressed and complete at the end.

While it is open there is `<stem>.mcap.part`, without chunks, so that a process that is killed loses what it had not
flushed and nothing else (`python -m tools.recover` completes it). The compressed file grows in memory, about 50 kB an
episode, and is written in one go under its final name.
"""

import contextlib
import gzip
import io
from collections.abc import Callable, Mapping
from pathlib import Path

import foxglove
from foxglove.mcap import MCAPWriteOptions

# 1 of zstd takes half the time of its default, 3, for 2 % more room.
_FINISHED = MCAPWriteOptions(compression_level=1, compression_threads=0)
_IN_PROGRESS = MCAPWriteOptions(compression=None, use_chunks=False, disable_seeking=True)

METADATA = "asddpg"  # name of the metadata record
CONFIG = "config.yaml.gz"  # name of the attachment


class RecordingFile:
    """Takes what is logged on a context's channels, from its making until it is finished or dropped."""

    def __init__(self, folder: Path, stem: str, context: foxglove.Context) -> None:
        """Open it.

        Raises:
            OSError: the file cannot be made.
        """
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._stem = folder, stem
        self.part = folder / f"{stem}.mcap.part"
        self._plain = _Plain(self.part)
        self._compressed = io.BytesIO()
        self._writers = (
            foxglove.open_mcap(self._plain, context=context, writer_options=_IN_PROGRESS),
            foxglove.open_mcap(self._compressed, context=context, writer_options=_FINISHED),
        )

    def describe(self, metadata: Mapping[str, str], packed: bytes) -> None:
        """Keep with it what it is of, and the configuration as pack() made it."""
        for writer in self._writers:
            writer.write_metadata(METADATA, dict(metadata))
            writer.attach(log_time=0, create_time=0, name=CONFIG, media_type="application/gzip", data=packed)

    def flush(self) -> None:
        """Bring everything logged so far into the file.

        Raises:
            OSError: it could not be written; what follows is not kept.
        """
        self._writers[0].flush()
        self._plain.check()

    def finish(self, outcome: str) -> Path:
        """Complete the file, under its final name.

        Raises:
            OSError: it could not be written.
        """
        self._close()
        path = self._folder / f"{self._stem}_{outcome}.mcap"
        whole = path.with_name(path.name + ".new")
        try:
            whole.write_bytes(self._compressed.getbuffer())
            whole.replace(path)
        except OSError:
            whole.unlink(missing_ok=True)
            raise
        self.part.unlink()
        return path

    def drop(self) -> None:
        """Close it and keep nothing."""
        self._close()
        self.part.unlink(missing_ok=True)

    def _close(self) -> None:
        for writer in self._writers:
            writer.close()
        self._plain.close()


def pack(config: str) -> bytes:
    """A configuration as it is attached: attachments are not compressed by the format itself."""
    return gzip.compress(config.encode(), mtime=0)


class _Plain:
    """A file for foxglove's writer that remembers its first error instead of raising it.

    Raised within the writer, which is not Python, an error would be printed and lost.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb")
        self._error: OSError | None = None

    def write(self, data: bytes | bytearray) -> int:
        self._try(lambda: self._file.write(data))
        return len(data)

    def flush(self) -> None:
        self._try(self._file.flush)

    def seek(self, offset: int, whence: int = 0) -> int:
        return self._file.tell()

    def check(self) -> None:
        if self._error is not None:
            raise self._error

    def close(self) -> None:
        with contextlib.suppress(OSError):  # nothing that matters is left to be written
            self._file.close()

    def _try(self, act: Callable[[], object]) -> None:
        if self._error is None:
            try:
                act()
            except OSError as error:
                self._error = error
