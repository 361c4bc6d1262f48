"""What a stranger's recording may not do: run code, name the place of a file, take all memory."""

import gzip
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import zstandard
from mcap.records import Chunk
from mcap.writer import CompressionType, Writer

from asddpg.errors import UserError
from asddpg.recording.files import chunks
from asddpg.recording.files.contents import Contents
from asddpg.recording.files.reading import open_recording
from asddpg.recording.messages.topics import OUTCOME, STEP
from tests.support.recordings import changed, evaluated
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


def with_config(change: Callable[[str], str]) -> Callable[[Contents], None]:
    """Another configuration in the attachment."""

    def act(contents: Contents) -> None:
        attachment = contents.attachments[0]
        attachment.data = gzip.compress(change(gzip.decompress(attachment.data).decode()).encode())

    return act


def with_messages(topic: str, data: bytes) -> Callable[[Contents], None]:
    """Other messages of a topic."""

    def act(contents: Contents) -> None:
        numbers = [channel.id for channel in contents.channels.values() if channel.topic == topic]
        for message in contents.messages:
            message.data = data if message.channel_id in numbers else message.data

    return act


def test_a_controller_of_theirs_is_not_made(recording: Path) -> None:
    theirs = with_config(lambda text: text.replace("type: proportional", "type: theirs:Factory"))
    path = changed(recording, Path("theirs.mcap"), theirs)
    assert "theirs:Factory" in open_recording(path).config
    replay_episode.main([str(path)])
    assert len(list(EpisodeStates(open_recording(path)))) > 1
    assert not Path("ran").exists()


@pytest.mark.parametrize(
    "line",
    [
        "seed: !!python/object/apply:builtins.exec [\"open('ran', 'w')\"]",
        "seed: !!python/module:theirs",
        "device: ${oc.env:HOME}",
        "device: &a [*a]",
        "a: &a [1]\nb: *a",
    ],
)
def test_configurations_that_are_more_than_data_are_refused(recording: Path, line: str) -> None:
    path = changed(recording, Path("theirs.mcap"), with_config(lambda text: f"{text}\n{line}\n"))
    for program in (replay_episode.main, episode_plot.main):
        with pytest.raises(UserError, match="damaged or not written by"):
            program([str(path)])
    with pytest.raises(UserError, match="damaged or not written by"):
        EpisodeStates(open_recording(path))
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
    monkeypatch.setattr(chunks, "LARGEST_CHUNK", MEGABYTE)
    with pytest.raises(UserError, match="a chunk that unpacks to"):
        open_recording(path)
    with pytest.raises(UserError, match="recovered|another program"):
        recover.main([str(path)])


def test_a_chunks_own_header_counts_and_not_only_the_files(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks, "LARGEST_CHUNK", MEGABYTE)
    data = zstandard.compress(b" " * 10 * MEGABYTE)
    chunk = Chunk("zstd", data, 0, 0, 0, uncompressed_size=1000)
    with pytest.raises(Exception, match="a chunk that unpacks to 10000000 bytes"):
        chunks.unpack_chunk(chunk)


def test_messages_nested_without_end_are_a_sentence(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = changed(recording, Path("theirs.mcap"), with_messages(STEP, b"[" * 100_000))
    with pytest.raises(UserError, match="is damaged or not a recording"):
        replay_episode.main([str(path)])
    episodes.main(["."])
    assert "damaged: theirs.mcap is damaged or not a recording" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["../../out", "/tmp/out", "won"])
def test_an_outcome_names_no_file(recording: Path, name: str) -> None:
    path = changed(recording, Path("theirs.mcap"), with_messages(OUTCOME, f'{{"outcome": "{name}"}}'.encode()))
    path = path.rename("theirs.mcap.part")
    with pytest.raises(UserError, match="which is no outcome"):
        recover.main([str(path)])
    assert sorted(each.name for each in Path().iterdir() if each.suffix != ".py") == [path.name]


def test_what_is_no_text_in_a_schema_is_a_sentence(recording: Path) -> None:
    def other_schemas(contents: Contents) -> None:
        for schema in contents.schemas.values():
            schema.data = b"\xff" * 20

    path = changed(recording, Path("theirs.mcap"), other_schemas)
    with pytest.raises(UserError, match="is damaged or not a recording"):
        list(open_recording(path).messages())
