"""Films of episodes, and pictures in recordings."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from asddpg import evaluate, train
from asddpg.build import navigation_env
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Decision, Driver
from asddpg.errors import UserError
from asddpg.recording.files.reading import Recording, open_recording
from asddpg.recording.pictures.cameras import Cameras
from asddpg.recording.pictures.film import Film
from asddpg.recording.recorder import Recorder, Selection, every_nth
from tasks.errors import TaskError
from tests.asddpg.recording.test_recording import PROVENANCE, environment_of
from tests.conftest import ROOT, TINY

av = pytest.importorskip("av")

SLOWLY = FixedDriver(lambda _: Decision(np.array([0.1, 0.2], dtype=np.float32), Driver.POLICY))


def film_of(path: Path, episodes: int = 1, steps: int = 6, **options: Any) -> None:
    environment = environment_of("nav_empty")
    film = Film(path, navigation_env(environment), width=96, height=64, **options)
    try:
        for _ in range(episodes):
            run_episode(environment, SLOWLY, (film,), max_steps=steps)
    finally:
        film.close()


def pictures_in(path: Path) -> list[np.ndarray[Any, Any]]:
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


# Films ------------------------------------------------------------------------------------------------------------


def test_a_film_shows_every_step_of_all_episodes_in_real_time(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    film_of(path, episodes=2)
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
        assert stream.average_rate == 5
        # The beginning, six steps, and 1.5 s to read how it ended.
        assert stream.frames == 2 * (1 + 6 + 8)
        assert float(stream.duration * stream.time_base) == pytest.approx(stream.frames / 5)
    pictures = pictures_in(path)
    assert len(pictures) == 30
    assert pictures[0].shape == (64, 96, 3)
    assert np.abs(pictures[1].astype(int) - pictures[6]).mean() > 0.5  # the caption alone would be less
    assert [file.name for file in tmp_path.iterdir()] == ["film.mp4"]


def test_a_faster_film_that_plays_while_it_is_loading(tmp_path: Path) -> None:
    film_of(tmp_path / "film.mp4", speed=3.0)
    with av.open(str(tmp_path / "film.mp4")) as container:
        assert container.streams.video[0].average_rate == 15
    content = (tmp_path / "film.mp4").read_bytes()
    assert 0 < content.index(b"moov") < content.index(b"mdat")


def test_an_interrupted_film_is_whole_up_to_there(tmp_path: Path) -> None:
    count = iter(range(4))

    def decide(_: Any) -> Decision:
        if next(count, None) is None:
            raise KeyboardInterrupt
        return Decision(np.zeros(2, dtype=np.float32), Driver.CONTROLLER)

    environment = environment_of("nav_empty")
    film = Film(tmp_path / "film.mp4", navigation_env(environment), width=96, height=64)
    with pytest.raises(KeyboardInterrupt):
        run_episode(environment, FixedDriver(decide), (film,))
    film.close()
    film.close()
    assert len(pictures_in(tmp_path / "film.mp4")) == 5


@pytest.mark.slow
def test_of_a_killed_process_s_film_all_but_the_last_second_can_be_played(tmp_path: Path) -> None:
    script = f"""
import os, signal
from pathlib import Path
from tests.asddpg.recording.test_film import *
environment = environment_of("nav_empty")
film = Film(Path({str(tmp_path / "film.mp4")!r}), navigation_env(environment), width=96, height=64)
run_episode(environment, SLOWLY, (film,), max_steps=20)
os.kill(os.getpid(), signal.SIGKILL)
"""
    done = subprocess.run([sys.executable, "-c", script], env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False)
    assert done.returncode == -signal.SIGKILL
    assert len(pictures_in(tmp_path / "film.mp4.part")) >= 29 - 2 * 5


def test_a_film_of_nothing_leaves_nothing(tmp_path: Path) -> None:
    film_of(tmp_path / "film.mp4", episodes=0)
    assert list(tmp_path.iterdir()) == []


def test_errors_are_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    environment = navigation_env(environment_of("nav_empty"))
    with pytest.raises(UserError, match=r"must end in \.mp4, not 'film\.avi'"):
        Film(tmp_path / "film.avi", environment)
    with pytest.raises(UserError, match="must be even, not 97 x 64"):
        Film(tmp_path / "film.mp4", environment, width=97, height=64)
    with pytest.raises(TaskError, match="no camera 'side'; there are top, chase, onboard, free"):
        Film(tmp_path / "film.mp4", environment, camera="side")
    with pytest.raises(UserError, match="the film .*none/film.mp4 cannot be written: No such file or directory$"):
        Film(tmp_path / "none" / "film.mp4", environment)
    monkeypatch.setitem(sys.modules, "av", None)  # as if it were not installed
    with pytest.raises(UserError, match="videos need av, which is not installed: pip install .asddpg.video"):
        Film(tmp_path / "film.mp4", environment)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "film.mp4.part").symlink_to("/dev/full")
    with pytest.raises(UserError, match=r"the film .*film\.mp4 cannot be written: No space left on device"):
        film_of(tmp_path / "film.mp4", steps=40)
    assert not (tmp_path / "film.mp4").exists()


@pytest.mark.long
def test_a_film_of_1000_episodes_keeps_its_memory(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    environment = environment_of("nav_empty")
    film = Film(tmp_path / "film.mp4", navigation_env(environment), width=64, height=48)

    def resident() -> float:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6

    def drive(episodes: int) -> float:
        for _ in range(episodes):
            run_episode(environment, SLOWLY, (film,), max_steps=5)
        return resident()

    before = drive(100)
    grown = drive(1000) - before
    with capsys.disabled():
        print(f"\n1000 episodes of film: {grown:+.1f} MB (bar: under 20)")
    assert grown < 20
    film.close()


# Cameras in recordings ----------------------------------------------------------------------------------------------


def recorded(folder: Path, is_video: bool, episodes: int = 1, steps: int = 12) -> list[Recording]:
    environment = environment_of("nav_empty")
    cameras = Cameras(navigation_env(environment), ("chase", "onboard"), 96, 64, is_video)
    recorder = Recorder(
        folder, navigation_env(environment), PROVENANCE, Selection(every_nth(1)), print, cameras=cameras
    )
    for _ in range(episodes):
        run_episode(environment, SLOWLY, (recorder,), max_steps=steps)
    cameras.close()
    return [open_recording(path) for path in sorted(folder.iterdir())]


def test_each_step_has_the_pictures_of_its_moment(tmp_path: Path) -> None:
    (recording,) = recorded(tmp_path, is_video=False)
    for camera in ("/camera/chase", "/camera/onboard"):
        messages = list(recording.messages(camera))
        assert [message.time for message in messages] == [message.time for message in recording.messages("/tf")]
        assert {message.content.format for message in messages} == {"jpeg"}
    (tmp_path / "picture.jpg").write_bytes(messages[-1].content.data)
    picture = np.asarray(Image.open(tmp_path / "picture.jpg")).astype(int)
    environment = environment_of("nav_empty")
    environment.reset(options={"start": recording.start, "goal": recording.goal})
    for _ in range(12):
        environment.step(SLOWLY.decide(np.zeros(0, dtype=np.float32)).action)
    rendered = navigation_env(environment).physics.render(64, 96, "onboard")
    assert np.abs(picture - rendered).mean() < 4


def nal_kinds(packet: bytes) -> list[int]:
    """Of the units in Annex B: 1 a slice, 5 one of a keyframe, 6 remarks, 7 and 8 parameters."""
    return [byte[0] & 31 for byte in re.findall(rb"\x00\x00\x01(.)", packet, re.DOTALL)]


def test_video_is_as_foxglove_wants_it(tmp_path: Path) -> None:
    """Annex B, a frame a message, each keyframe behind its parameters, and in each file the first is one."""
    for recording in recorded(tmp_path, is_video=True, episodes=2):
        messages = list(recording.messages("/camera/chase"))
        assert len(messages) == 13
        assert {message.content.format for message in messages} == {"h264"}
        kinds = [nal_kinds(message.content.data) for message in messages]
        assert {kind for kind in kinds[0] if kind != 6} == {5, 7, 8}
        assert [5 in kind for kind in kinds] == [7 in kind for kind in kinds]
        assert all(kind == [1] for kind in kinds if 5 not in kind)
        decoder = av.CodecContext.create("h264", "r")
        packets = [*(av.Packet(message.content.data) for message in messages), None]
        frames = [frame for packet in packets for frame in decoder.decode(packet)]
        assert len(frames) == 13
        assert av.video.frame.PictureType.B not in {frame.pict_type for frame in frames}


def test_pictures_change_nothing_that_is_learned(tmp_path: Path) -> None:
    arguments = ["task=nav_empty", *TINY, "total_steps=120", "validation.every=0", "record.every=1"]
    train.main([*arguments, "record.cameras=[chase]", "record.picture_size=[32,24]", f"run_dir={tmp_path / 'with'}"])
    train.main([*arguments, f"run_dir={tmp_path / 'without'}"])
    assert (tmp_path / "with/metrics.csv").read_bytes() == (tmp_path / "without/metrics.csv").read_bytes()
    files = sorted((tmp_path / "with/episodes").iterdir())
    assert len(list(open_recording(files[0]).messages("/camera/chase"))) > 10


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["record.cameras=[side]"], "no camera 'side'; there are top, chase, onboard, free"),
        (["record.cameras=[top,top]"], "record.cameras must be names of cameras, each once"),
        (["record.codec=png"], "record.codec must be jpeg or h264, not 'png'"),
        (["record.picture_size=[321,240]"], "record.picture_size must be width and height, two even numbers"),
        (["record.cameras=[top]", "record.every=0"], "none is made: record.every=1 records all"),
    ],
)
def test_invalid_options_of_cameras_are_refused_before_the_first_step(
    arguments: list[str], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((UserError, TaskError), match=sentence):
        evaluate.main(["agent=controller", "task=nav_empty", "episodes=1", "record.every=1", *arguments])
    with pytest.raises((UserError, TaskError), match=sentence):
        train.main(["task=nav_empty", *TINY, *arguments, "run_dir=run"])
    assert list(tmp_path.iterdir()) == []
