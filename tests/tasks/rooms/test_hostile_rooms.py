"""Broken and hostile files of rooms: a sentence each, in bounded time and memory, and nothing written."""

import resource
import time
from pathlib import Path

import numpy as np
import pytest

from tasks.errors import TaskError
from tasks.rooms.reading import find_room
from tasks.rooms.scene import compile_room
from tests.support.hostile_rooms import STILL_ROOMS, write_hostile

LONGEST, MOST_MEMORY = 10.0, 1_500_000  # s a file, kB more than before


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Names of the rooms."""
    return list(write_hostile(tmp_path_factory.mktemp("hostile")))


def listing(folder: Path) -> dict[str, int]:
    return {str(path): path.lstat().st_mtime_ns for path in folder.rglob("*")}


def test_300_files_end_in_a_sentence_each(
    hostile: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    assert len(hostile) >= 300
    folder = Path(hostile[-1]).parent
    monkeypatch.chdir(tmp_path)
    before, memory = listing(folder), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    sentences: dict[str, str] = {}
    for name in hostile:
        begun = time.process_time()
        try:
            room = find_room(name)
            compile_room(room)
        except TaskError as error:
            sentences[name] = str(error)
        else:
            numbers = [number for each in room.obstacles for number in (*each.position, *each.size, each.mass)]
            assert np.isfinite(numbers).all(), name
        assert time.process_time() - begun < LONGEST, name
    assert len(sentences) > 230
    assert not [sentence for sentence in sentences.values() if "\n" in sentence or len(sentence) > 600]
    assert not [name for name in hostile if name not in sentences and not Path(name).name.startswith(STILL_ROOMS)]
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < MOST_MEMORY
    assert listing(folder) == before
    assert not list(tmp_path.iterdir())
    assert capfd.readouterr() == ("", "")
