"""Interrupted and damaged recordings, and what is saved of them."""

import contextlib
import os
import random
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Channel, McapRecord, Message

from asddpg.errors import UserError
from asddpg.recording.files.reading import open_recording
from asddpg.recording.files.recovery import complete_interrupted
from asddpg.recording.recorder import BATCH_STEPS
from tests.conftest import ROOT, TINY
from tests.node.make_recordings import CUT_AFTER, make_part, record_turning
from tests.support.counting_controller import COUNT
from tests.support.recordings import changed, evaluated
from tools import episodes, recover, replay_episode

# A process -------------------------------------------------------------------------------------------------------


def killed_training(folder: Path, seconds: float) -> int:
    """Let a training be killed some time after its first episode; the steps that it had decided."""
    count = folder / "count"
    arguments = ["task=nav_complex", *TINY[1:], "total_steps=100000", "record.every=1", "record.keep=100000"]
    arguments += ["validation.every=0", "controller.type=tests.support.counting_controller:CountingController"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), COUNT: str(count)}
    command = [sys.executable, "-m", "asddpg.train", *arguments, f"run_dir={folder / 'run'}"]
    with (folder / "log").open("wb") as log:
        training = subprocess.Popen(command, env=environment, cwd=folder, stdout=log, stderr=log)
        try:
            deadline = time.monotonic() + 120
            while not list(folder.glob("run/episodes/*.mcap")):
                assert training.poll() is None, (folder / "log").read_text()
                assert time.monotonic() < deadline
                time.sleep(0.02)
            time.sleep(seconds)
            assert training.poll() is None, (folder / "log").read_text()
        finally:
            training.kill()
            training.wait()
    return count.stat().st_size


def check_killed(folder: Path, seconds: float, capsys: pytest.CaptureFixture[str]) -> None:
    decided = killed_training(folder, seconds)
    recordings = folder / "run/episodes"
    for part in recordings.glob("*.part"):
        stem = part.name.removesuffix(".mcap.part")
        if not list(recordings.glob(f"{stem}_*.mcap")) and open_recording_has_steps(part):
            recover.main([str(part)])
        assert part.exists()
    saved = sum(len(open_recording(path).steps()) for path in recordings.glob("*.mcap"))
    assert decided - BATCH_STEPS <= saved <= decided
    capsys.readouterr()
    replay_episode.main([str(recordings)])
    out = capsys.readouterr().out
    assert out.count("the same to the last bit") == len(list(recordings.glob("*.mcap")))


def open_recording_has_steps(part: Path) -> bool:
    """Whether a step was brought to the disk before the kill."""
    try:
        return bool(open_recording(part).steps())
    except UserError:  # killed before the beginning was whole
        return False


def test_a_killed_training_loses_the_last_steps_at_most(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    check_killed(tmp_path, 0.4, capsys)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(20))
def test_killed_at_random_moments(tmp_path: Path, capsys: pytest.CaptureFixture[str], seed: int) -> None:
    check_killed(tmp_path, random.Random(seed).uniform(0.0, 3.0), capsys)


# A file ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def part(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_part(tmp_path_factory.mktemp("killed"))


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A complete one, of several chunks."""
    arguments = ("agent=controller", "task=nav_gazebo", "episodes=4")
    return max(evaluated(tmp_path_factory.mktemp("evaluated"), *arguments), key=lambda path: path.stat().st_size)


def test_a_part_becomes_a_complete_recording(part: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "new.mcap"
    before = part.read_bytes()
    recover.main([str(part), str(target)])
    assert "24 steps saved, cut, in" in capsys.readouterr().out
    assert part.read_bytes() == before
    whole = open_recording(next((part.parent / "whole").glob("*.mcap")))
    found = open_recording(target)
    assert found.facts == whole.facts
    assert found.config == whole.config
    assert found.steps() == whole.steps()[: CUT_AFTER - CUT_AFTER % BATCH_STEPS]
    for topic in ("/tf", "/scan", "/odom", "/step", "/cmd_vel", "/scene", "/goal"):
        # As text: each file brings protobuf classes of its own.
        saved, written = ([(each.time, str(each.content)) for each in file.messages(topic)] for file in (found, whole))
        assert saved
        assert saved == written[: len(saved)]
    outcome = found.outcome()
    assert (outcome["outcome"], outcome["steps"], outcome["controller_share"]) == ("cut", 24, 0.0)
    assert outcome["total_reward"] == pytest.approx(sum(step["reward"] for step in found.steps()))
    assert outcome["path_length"] == pytest.approx(24 * 0.2 * 0.05, abs=0.02)  # the least speed of nav_complex
    *_, path = found.messages("/path")
    assert [len(line.points) for line in path.content.entities[0].lines] == [25]
    *_, log = found.messages("/log")
    assert f"recovered from {part.name}" in log.content.message


def test_a_recovered_outcome_equals_the_recorded_one(recording: Path, tmp_path: Path) -> None:
    def remove_outcome(records: list[McapRecord]) -> None:
        numbers = {each.id for each in records if isinstance(each, Channel) and each.topic == "/outcome"}
        records[:] = [each for each in records if not (isinstance(each, Message) and each.channel_id in numbers)]

    cut = changed(recording, tmp_path / "00.mcap", remove_outcome)
    cut.write_bytes(cut.read_bytes()[:-1])
    recover.main([str(cut)])
    recovered, original = open_recording(tmp_path / "00_cut.mcap").outcome(), open_recording(recording).outcome()
    assert (recovered.pop("outcome"), original.pop("outcome") != "cut") == ("cut", True)
    assert recovered == pytest.approx(original, rel=0.01)


def test_the_new_file_is_indexed_and_compressed(part: Path, tmp_path: Path) -> None:
    recover.main([str(part), str(tmp_path / "new.mcap")])
    with (tmp_path / "new.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == sum(1 for _ in reader.iter_messages())
        assert {index.compression for index in summary.chunk_indexes} == {"zstd"}
        assert summary.attachment_indexes
        assert summary.metadata_indexes
    assert (tmp_path / "new.mcap").stat().st_size < part.stat().st_size / 2


def test_wherever_a_file_ends_whole_steps_are_saved(part: Path, tmp_path: Path) -> None:
    whole = part.read_bytes()
    steps = open_recording(part).steps()
    saved = []
    for size in [*range(len(whole) * 4 // 5, len(whole), 331), len(whole)]:  # the last ten steps take a quarter
        source, target = tmp_path / f"{size}.mcap.part", tmp_path / f"{size}_cut.mcap"
        source.write_bytes(whole[:size])
        assert open_recording(source).steps() == steps[: len(open_recording(source).steps())]
        recover.main([str(source)])
        found = open_recording(target)
        saved.append(len(found.steps()))
        assert found.steps() == steps[: saved[-1]]
        assert len(list(found.messages("/tf"))) == len(list(found.messages("/scan"))) == saved[-1] + 1
    assert saved == sorted(saved)
    assert saved[0] < saved[-1]


def test_of_a_truncated_file_whole_chunks_are_saved(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recording = record_turning(tmp_path / "long", 150)
    whole, steps = recording.read_bytes(), open_recording(recording).steps()
    half, end = tmp_path / "00_cut.mcap", tmp_path / "01_cut.mcap"
    half.write_bytes(whole[: len(whole) * 3 // 5])
    recover.main([str(half)])
    (part,) = tmp_path.glob("00_recovered_*.mcap")
    saved = open_recording(part).steps()
    assert saved == steps[: len(saved)]
    assert 50 < len(saved) < len(steps)
    end.write_bytes(whole[:-1])
    recover.main([str(end)])
    (complete,) = tmp_path.glob("01_recovered_*.mcap")
    assert open_recording(complete).outcome() == open_recording(recording).outcome()
    capsys.readouterr()
    replay_episode.main([str(part), str(complete)])
    assert capsys.readouterr().out.count("the same to the last bit") == 2
    half.unlink()
    end.unlink()
    episodes.main([str(tmp_path)])
    assert "3 recordings" in capsys.readouterr().out


def test_wrong_bytes_are_not_taken_for_right_ones(recording: Path, tmp_path: Path) -> None:
    whole = recording.read_bytes()
    steps = open_recording(recording).steps()
    for begin in range(2000, len(whole) - 5000, 1500):
        source = tmp_path / f"{begin}.mcap"
        source.write_bytes(whole[:begin] + bytes(byte ^ 0x55 for byte in whole[begin : begin + 3]) + whole[begin + 3 :])
        try:
            recover.main([str(source), str(tmp_path / f"{begin}_new.mcap")])
        except UserError as error:
            assert "recover" in str(error)  # noqa: PT017
            continue
        saved = open_recording(tmp_path / f"{begin}_new.mcap").steps()
        assert saved == steps[: len(saved)]


def test_mcap_s_own_reader_reads_a_part_to_its_last_batch(part: Path) -> None:
    steps = 0
    with part.open("rb") as file:
        messages = NonSeekingReader(file).iter_messages(log_time_order=False)
        with contextlib.suppress(McapError):  # there is no summary
            for _, channel, _ in messages:
                steps += channel.topic == "/step"
    assert steps == CUT_AFTER - CUT_AFTER % BATCH_STEPS


def test_an_interrupted_recording_is_completed_once(part: Path, tmp_path: Path) -> None:
    own = Path(shutil.copy(part, tmp_path))
    path = complete_interrupted(own)
    assert path == tmp_path / part.name.replace(".mcap.part", "_cut.mcap")
    assert len(open_recording(path).steps()) == open_recording(path).outcome()["steps"] == 24
    content = path.read_bytes()
    shutil.copy(part, tmp_path)  # the process was killed before it could delete the part
    assert complete_interrupted(own) == path
    assert [each.read_bytes() for each in tmp_path.iterdir()] == [content]


@pytest.mark.parametrize("size", [0, 8, 300, 9000])
def test_a_part_without_a_whole_step_is_deleted(part: Path, tmp_path: Path, size: int) -> None:
    own = tmp_path / part.name
    for content in (part.read_bytes()[:size], bytes(size)):
        own.write_bytes(content)
        assert complete_interrupted(own) is None
        assert list(tmp_path.iterdir()) == []


# Errors ----------------------------------------------------------------------------------------------------------


def test_nothing_is_overwritten(part: Path, tmp_path: Path) -> None:
    there = tmp_path / "there.mcap"
    there.write_text("mine")
    with pytest.raises(UserError, match="exists already; name another file"):
        recover.main([str(part), str(there)])
    assert there.read_text() == "mine"


def test_the_rest_stays_whatever_the_new_file_is_called(part: Path, tmp_path: Path) -> None:
    source, target = tmp_path / "a.mcap.part", tmp_path / "a.mcap"
    source.write_bytes(part.read_bytes())
    recover.main([str(source), str(target)])
    assert source.read_bytes() == part.read_bytes()
    assert open_recording(target).steps()


def test_a_full_disk_leaves_nothing(part: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    own = Path(shutil.copy(part, tmp_path))
    monkeypatch.setattr("asddpg.atomic_write.os.fsync", full)
    assert complete_interrupted(own) is None  # the part stays
    with pytest.raises(UserError, match="cannot be written: No space left on device"):
        recover.main([str(part), str(tmp_path / "new.mcap")])
    assert list(tmp_path.iterdir()) == [own]


def test_errors_are_one_sentence(part: Path, recording: Path, tmp_path: Path) -> None:
    def of_another_program(records: list[McapRecord]) -> None:
        records[:] = [each for each in records if isinstance(each, Channel | Message)]

    whole = part.read_bytes()
    for name, content in (("empty", b""), ("begun", whole[:300]), ("stepless", whole[: whole.index(b"/cmd_vel")])):
        (tmp_path / f"{name}.mcap.part").write_bytes(content)
    (tmp_path / "text.mcap").write_text("a text\n" * 100)
    not_whole = "nothing of .* can be recovered, its beginning is not whole"
    for arguments, sentence in (
        ([], "FILE is missing"),
        ([tmp_path / "none.mcap.part"], "cannot be read: No such file"),
        ([tmp_path], "cannot be read: Is a directory"),
        ([tmp_path / "empty.mcap.part"], not_whole),
        ([tmp_path / "begun.mcap.part"], not_whole),
        ([tmp_path / "text.mcap"], not_whole),
        ([tmp_path / "stepless.mcap.part"], "holds no whole step"),
        ([recording], "is whole, there is nothing to recover"),
        ([changed(recording, tmp_path / "others.mcap", of_another_program)], "a recording of another program"),
        ([part, tmp_path / "new.txt"], "a path that ends in .mcap"),
        ([part, tmp_path / "nowhere" / "new.mcap"], "cannot be written: No such file"),
    ):
        with pytest.raises(UserError, match=sentence):
            recover.main([str(argument) for argument in arguments])
