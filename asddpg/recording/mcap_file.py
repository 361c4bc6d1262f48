"""A recording's file: a journal while its episode goes on, told in full, compressed and complete at the end.

While it is open there is `<stem>.mcap.part`, without chunks, so that a process that is killed loses what it had not
flushed and nothing else (`python -m tools.recover` completes it). It holds moments as they were read, see journal.py;
the final file is told of the same, and written by foxglove, at the end.
"""

import contextlib
import gzip
import io
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import IO

import foxglove
from foxglove.mcap import MCAPWriteOptions
from mcap.records import Attachment, Metadata

from asddpg.recording import journal
from asddpg.recording.channels import Channels
from asddpg.recording.journal import Layout
from asddpg.recording.moments import Moment
from asddpg.recording.plain_mcap import OtherChannel, PlainMcap
from asddpg.recording.topics import SCENE

_FINISHED = MCAPWriteOptions(compression_threads=0, emit_summary_offsets=False)

METADATA = "asddpg"  # name of the metadata record
CONFIG = "config.yaml.gz"  # name of the attachment


class RecordingFiles:
    """Recordings of the same channels and configuration."""

    def __init__(self, folder: Path, channels: Channels, config: str, layout: Layout, scene: bytes) -> None:
        """Take the configuration as YAML, how moments are told, and the message of /scene; nothing is made yet."""
        packed = gzip.compress(config.encode(), mtime=0)  # attachments are not compressed by the format itself
        self.folder, self.channels = folder, channels
        self.config = Attachment(create_time=0, log_time=0, name=CONFIG, media_type="application/gzip", data=packed)
        self.plain = PlainMcap(
            channels.schemas, self.config, [OtherChannel(journal.TOPIC, journal.ENCODING, layout.as_text())]
        )
        self.scene = self.plain.messages([(SCENE, scene, 0)])

    def compressed(self, metadata: Mapping[str, str], tell: Callable[[], None]) -> memoryview:
        """A whole file of what is told to the channels."""
        file, config = io.BytesIO(), self.config
        with foxglove.open_mcap(file, context=self.channels.context, writer_options=_FINISHED) as writer:
            writer.write_metadata(METADATA, dict(metadata))
            writer.attach(**vars(config))
            tell()
        return file.getbuffer()


class RecordingFile:
    """Takes moments, from its making until it is finished or dropped."""

    def __init__(self, files: RecordingFiles, stem: str, metadata: Mapping[str, str]) -> None:
        """Open it.

        Args:
            files: where it belongs.
            stem: its name without endings.
            metadata: what it is of.

        Raises:
            OSError: the file cannot be made.
        """
        self._files, self._stem, self._metadata = files, stem, metadata
        self.part = files.folder / f"{stem}.mcap.part"
        self._file = _opened(self.part)
        self._file.write(files.plain.beginning(Metadata(METADATA, dict(metadata))) + files.scene)
        self._file.flush()

    def add(self, moments: Sequence[Moment]) -> None:
        """Bring moments to the disk, those that follow on the last ones.

        Raises:
            OSError: they could not be written.
        """
        self._file.write(self._files.plain.messages([(journal.TOPIC, journal.packed(moments), moments[-1].time)]))
        self._file.flush()

    def finish(self, outcome: str, tell: Callable[[], None]) -> Path:
        """Put the whole file, which `tell` tells to the channels, in the place of the journal; under its final name.

        Raises:
            OSError: it could not be written.
        """
        self._file.close()
        path = self._files.folder / f"{self._stem}_{outcome}.mcap"
        whole = self._files.folder / f"{self._stem}.mcap.new"
        try:
            whole.write_bytes(self._files.compressed(self._metadata, tell))
            whole.replace(path)
        except OSError:
            whole.unlink(missing_ok=True)
            raise
        self.part.unlink()
        return path

    def drop(self) -> None:
        """Close it and keep nothing."""
        with contextlib.suppress(OSError):  # nothing that matters is left to be written
            self._file.close()
        self.part.unlink(missing_ok=True)


def _opened(path: Path) -> IO[bytes]:
    try:
        return path.open("wb")
    except FileNotFoundError:
        path.parent.mkdir(parents=True, exist_ok=True)
        return path.open("wb")
