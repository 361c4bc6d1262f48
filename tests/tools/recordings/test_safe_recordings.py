"""An untrusted recording runs no code, names no file, and does not exhaust the memory."""

import sys
from pathlib import Path

import pytest
import zstandard
from mcap.records import Chunk, McapRecord, Schema
from mcap.writer import CompressionType, Writer

from asddpg.errors import UserError
from asddpg.recording.files import records
from asddpg.recording.files.reading import open_recording
from asddpg.recording.messages.topics import OUTCOME, STEP
from tests.support.recordings import changed, evaluated, with_config, with_messages
from tools import episode_plot, episodes, recover, replay_episode
from tools.recordings.episode_states import EpisodeStates

MEGABYTE = 10**6


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    (path,) = evaluated(tmp_path_factory.mktemp("evaluated"), "agent=controller", "task=nav_empty", "episodes=1")
    return path


@pytest.fixture(autouse=True)
def _a_module_of_theirs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "theirs.py").write_text('open("ran", "w").close()\nFactory = object\n')
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "theirs", raising=False)
    monkeypatch.chdir(tmp_path)


def test_a_foreign_controller_is_not_made(recording: Path) -> None:
    theirs = with_config(lambda text: text.replace("type: proportional", "type: theirs:Factory"))
    path = changed(recording, Path("theirs.mcap"), theirs)
    assert "theirs:Factory" in open_recording(path).config
    replay_episode.main([str(path)])
    assert len(list(EpisodeStates(open_recording(path)))) > 1
    assert not Path("ran").exists()


def test_an_attachment_that_unpacks_without_end_is_not_unpacked(recording: Path) -> None:
    path = changed(recording, Path("theirs.mcap"), with_config(lambda text: text + "#" * 100 * MEGABYTE))
    with pytest.raises(UserError, match="a configuration of more than 1000000 bytes"):
        open_recording(path)


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4])
def test_a_chunk_that_unpacks_without_end_is_not_unpacked(
    compression: CompressionType, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = Path("theirs.mcap")
    with path.open("wb") as file:
        writer = Writer(file, compression=compression)
        writer.start()
        channel = writer.register_channel(STEP, "json", 0)
        writer.add_message(channel, 0, b" " * 10 * MEGABYTE, 0)
        writer.finish()  # type: ignore[no-untyped-call]
    assert path.stat().st_size < MEGABYTE / 10
    monkeypatch.setattr(records, "MAX_CHUNK", MEGABYTE)
    with pytest.raises(UserError, match="a chunk that unpacks to"):
        open_recording(path)
    with pytest.raises(UserError, match="recovered|another program"):
        recover.main([str(path)])


@pytest.mark.parametrize(
    "line",
    [
        "seed: !!python/object/apply:builtins.exec [\"open('ran', 'w')\"]",
        "seed: !!python/module:theirs",
        "device: &a [*a]",
        "a: &a [1]\nb: *a",
    ],
)
def test_a_configuration_that_is_more_than_values_is_refused(recording: Path, line: str) -> None:
    path = changed(recording, Path("theirs.mcap"), with_config(lambda text: f"{text}\n{line}\n"))
    for program in (replay_episode.main, episode_plot.main):
        with pytest.raises(UserError, match="damaged or not written by"):
            program([str(path)])
    assert not Path("ran").exists()


def test_damaged_contents_are_one_sentence(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def break_schemas(contents: list[McapRecord]) -> None:
        for record in contents:
            if isinstance(record, Schema):
                record.data = b"\xff" * 20

    for change in (with_messages(STEP, lambda _: b"[" * 100_000), break_schemas):
        path = changed(recording, Path("theirs.mcap"), change)
        with pytest.raises(UserError, match="is damaged or not a recording"):
            list(open_recording(path).messages())
        path.write_bytes(path.read_bytes()[:-1])
        with pytest.raises(UserError, match="holds no whole step"):
            recover.main([str(path)])
        episodes.main(["."])
        assert "damaged: theirs.mcap is damaged or not a recording" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["../../out", "/tmp/out", "won"])
def test_an_outcome_names_no_file(recording: Path, name: str) -> None:
    outcome = f'{{"outcome": "{name}"}}'.encode()
    changed(recording, Path("theirs.mcap.part"), with_messages(OUTCOME, lambda _: outcome))
    with pytest.raises(UserError, match="which is no outcome"):
        recover.main(["theirs.mcap.part"])
    assert sorted(each.name for each in Path().iterdir() if each.suffix != ".py") == ["theirs.mcap.part"]


def test_a_chunks_own_header_counts_and_not_only_the_files(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(records, "MAX_CHUNK", MEGABYTE)
    data = zstandard.compress(b" " * 10 * MEGABYTE)
    chunk = Chunk("zstd", data, 0, 0, 0, uncompressed_size=1000)
    with pytest.raises(Exception, match="a chunk that unpacks to 10000000 bytes"):
        records.unpack_chunk(chunk)
