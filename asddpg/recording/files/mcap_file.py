"""A recording's file: a journal while its episode goes on, told in full, compressed and complete at the end.

From the first moments that are brought to the disk there is `<stem>.mcap.part`, without chunks, so that a process that
is killed loses what came after them and nothing else (`python -m tools.recover` completes it). It holds moments as they
were read, see journal.py; the final file is told of the same, and written by foxglove, at the end.

Both are written through file descriptors: the objects of Python's own that stand before them cost 2 µs a step.
"""

import contextlib
import gzip
import io
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import foxglove
from foxglove.mcap import MCAPWriteOptions
from mcap.records import Attachment, Metadata

from asddpg.recording.files import journal
from asddpg.recording.files.journal import Layout
from asddpg.recording.files.plain_mcap import OtherChannel, PlainMcap
from asddpg.recording.messages.channels import Channels
from asddpg.recording.messages.topics import SCENE
from asddpg.recording.samples import Moment

# A higher level makes files of this size no smaller, and takes 3 µs a step more.
_FINISHED = MCAPWriteOptions(compression_level=2, compression_threads=0, emit_summary_offsets=False)

_NEW, _RIGHTS = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o666  # less the umask
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
        """Make nothing yet.

        Args:
            files: where it belongs.
            stem: its name without endings.
            metadata: what it is of.
        """
        self._files, self._metadata = files, metadata
        self._base = os.path.join(files.folder, stem)
        self._part = f"{self._base}.mcap.part"
        self._journal: int | None = None  # file descriptor

    def add(self, moments: Sequence[Moment]) -> None:
        """Bring moments to the disk, those that follow on the last ones.

        Raises:
            OSError: they could not be written.
        """
        plain = self._files.plain
        message = plain.messages([(journal.TOPIC, journal.packed(moments), moments[-1].time)])
        if self._journal is None:
            self._journal = _opened(self._part)
            message = plain.beginning(Metadata(METADATA, dict(self._metadata))) + self._files.scene + message
        _write(self._journal, message)

    def finish(self, outcome: str, tell: Callable[[], None]) -> Path:
        """Put the whole file, which `tell` tells to the channels, in the place of the journal; under its final name.

        Raises:
            OSError: it could not be written.
        """
        path, whole = f"{self._base}_{outcome}.mcap", f"{self._base}.mcap.new"
        content = self._files.compressed(self._metadata, tell)
        try:
            _write_new(whole, content)
            os.replace(whole, path)
        except OSError:
            with contextlib.suppress(OSError):
                os.unlink(whole)
            raise
        self.drop()
        return Path(path)

    def drop(self) -> None:
        """Close the journal and keep nothing of it."""
        journal, self._journal = self._journal, None
        if journal is None:
            return
        with contextlib.suppress(OSError):  # nothing that matters is left to be written
            os.close(journal)
        with contextlib.suppress(OSError):  # whoever looks for it finds the whole file, or is told that there is none
            os.unlink(self._part)


def _write_new(path: str, content: bytes | memoryview) -> None:
    file = _opened(path)
    try:
        _write(file, content)
    finally:
        os.close(file)


def _opened(path: str) -> int:
    """A new file, in a folder that is made with the first one."""
    try:
        return os.open(path, _NEW, _RIGHTS)
    except FileNotFoundError:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        return os.open(path, _NEW, _RIGHTS)


def _write(file: int, content: bytes | memoryview) -> None:
    """Write all of it: a disk that is nearly full takes a part, and only then says so."""
    written = os.write(file, content)
    while written < len(content):
        written += os.write(file, content[written:])
