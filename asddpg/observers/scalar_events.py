"""Scalars for TensorBoard, written by the training's own thread.

Torch's SummaryWriter writes in a thread of its own, where a full disk ends in a traceback and goes unnoticed; and
it names its files by the clock, which may be set back.
"""

import time
from pathlib import Path

from tensorboard.compat.proto.event_pb2 import Event
from tensorboard.compat.proto.summary_pb2 import Summary
from tensorboard.summary.writer.record_writer import RecordWriter

from asddpg.atomic_write import closed_on_error


class ScalarEvents:
    """Writes scalars, each at a training step; every method raises OSError where the file cannot be written."""

    def __init__(self, folder: Path, step: int = 0) -> None:
        """Open a file named by the steps made before: TensorBoard reads a folder in the order of names."""
        folder.mkdir(parents=True, exist_ok=True)
        self._file = (folder / f"events.out.tfevents.{step:010d}").open("ab")
        self._records = RecordWriter(self._file)
        with closed_on_error(self._file):
            if not self._file.tell():
                self._write(Event(wall_time=time.time(), file_version="brain.Event:2"))
                self.flush()

    def add_scalar(self, tag: str, scalar_value: float, global_step: int) -> None:
        """Write one figure."""
        summary = Summary(value=[Summary.Value(tag=tag, simple_value=scalar_value)])
        self._write(Event(wall_time=time.time(), step=global_step, summary=summary))

    def flush(self) -> None:
        """Flush to the file."""
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _write(self, event: Event) -> None:
        self._records.write(event.SerializeToString())
