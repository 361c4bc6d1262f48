"""Files that are whole or, if there was one before, the one before."""

import os
from pathlib import Path


def write_whole(path: Path, content: bytes | memoryview) -> None:
    """Write a file, brought to the disk before it takes its name.

    Raises:
        OSError: it could not be written; what was there before is as it was.
    """
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)  # it holds room that others need
        raise
