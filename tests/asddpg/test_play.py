"""Playing episodes."""

import io
import re
import shutil
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from asddpg import play
from asddpg.config import PlayConfig
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Episode, Observer
from asddpg.recording.files.reading import open_recording
from tests.conftest import free_port
from tests.support.foxglove_viewer import Viewer

LINE = re.compile(r"episode (\d+): (\w+) after (\d+) steps, return (-?[\d.]+), controller (\d+) %, (\S+\.mcap)")
POLICY = ["run=pretrained:nav_complex", "seed=3"]


def lines_of(text: str) -> list[tuple[str, ...]]:
    return [match.groups() for match in LINE.finditer(text)]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("here")
def test_each_episode_is_printed_in_a_line_and_recorded(capsys: pytest.CaptureFixture[str]) -> None:
    play.main([*POLICY, "episodes=2"])
    out = capsys.readouterr().out
    lines = lines_of(out)
    assert [number for number, *_ in lines] == ["1", "2"]
    assert sorted(str(path) for path in Path("played_episodes").iterdir()) == [file for *_, file in lines]
    for _, outcome, steps, total_reward, share, file in lines:
        recording = open_recording(file)
        found = recording.outcome()
        assert (found["outcome"], found["steps"]) == (outcome, int(steps))
        assert found["total_reward"] == pytest.approx(float(total_reward), abs=0.01)
        assert share == "0"
        assert recording.facts["pairs"] == "drawn, seed 3"
        assert recording.facts["driver"] == "actor"
    assert "2 episodes recorded in played_episodes; in Foxglove: Open local file" in out
    layout = re.search(r"Import from file, (\S+)", out)
    assert layout
    assert Path(layout[1]).is_file()


@pytest.mark.usefixtures("here")
def test_a_seed_gives_the_same_episodes_to_every_driver(capsys: pytest.CaptureFixture[str]) -> None:
    pairs = []
    for arguments in (POLICY, [*POLICY, "driver=switch"], [*POLICY, "driver=controller"], [*POLICY, "seed=4"]):
        play.main([*arguments, "episodes=2", "record.only=[2]", "record.every=0"])
        ((*_, file),) = lines_of(capsys.readouterr().out)
        recording = open_recording(file)
        pairs.append((recording.start, recording.goal))
    assert pairs[0] == pairs[1] == pairs[2] != pairs[3]


@pytest.mark.usefixtures("here")
def test_a_seed_that_was_not_given_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    play.main(["agent=random", "task=nav_empty", "episodes=1"])
    first = capsys.readouterr().out
    seed = re.search(r"seed=\d+", first)
    assert seed
    play.main(["agent=random", "task=nav_empty", "episodes=1", seed[0]])
    assert capsys.readouterr().out.replace("played_episodes_2", "played_episodes") == first


@pytest.mark.usefixtures("here")
def test_a_run_keeps_what_is_played_of_it(tiny_run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(tiny_run, "run")
    play.main(["run=run", "checkpoint=best", "driver=controller", "episodes=1", "seed=1"])
    ((*_, share, file),) = lines_of(capsys.readouterr().out)
    assert share == "100"
    assert Path(file).parent == Path("run/played_episodes")
    assert open_recording(file).facts["driver"] == "controller"
    assert not Path("played_episodes").exists()


def test_three_episodes_are_driven_by_default() -> None:
    assert PlayConfig().episodes is None
    assert play.EPISODES == 3


def test_ctrl_c_completes_the_recording(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Interrupting(Observer):
        def step(self, step: Any, learned: Any) -> None:
            raise KeyboardInterrupt

    def interrupted(environment: Any, driver: Any, observers: Any) -> Episode:
        return run_episode(environment, driver, [*observers, Interrupting()])

    monkeypatch.setattr(play, "run_episode", interrupted)
    with pytest.raises(KeyboardInterrupt):
        play.main(["agent=controller", "task=nav_empty"])
    (path,) = (here / "played_episodes").iterdir()
    assert path.name.endswith("_cut.mcap")
    assert open_recording(path).outcome()["steps"] == 1
    assert "1 episode recorded in played_episodes" in capsys.readouterr().out


def watched_play(*topics: str, arguments: Sequence[str] = ()) -> Viewer:
    """A live play of one episode; returns its viewer at the end."""
    port = free_port()
    command = ["agent=controller", "task=nav_empty", "seed=1", "episodes=1", "live=true", f"port={port}", "speed=0"]
    thread = threading.Thread(target=play.main, args=([*command, *arguments],))
    thread.start()
    with Viewer.when_served(port) as viewer:
        viewer.watch(*topics)
        viewer.until(lambda: viewer.of("/outcome") and viewer.of("/outcome")[-1]["outcome"] == "reached")
        thread.join()
    return viewer


def test_live_and_recorded_at_once(here: Path) -> None:
    viewer = watched_play("/step", "/outcome")
    (path,) = (here / "played_episodes").iterdir()
    assert open_recording(path).outcome() == viewer.of("/outcome")[-1]
    recorded = [step["digest"] for step in open_recording(path).steps()]
    seen = [step["digest"] for step in viewer.of("/step")]
    assert seen == recorded[-len(seen) :]
    assert len(seen) > len(recorded) - 5  # it may come as the first steps are made


@pytest.mark.parametrize("codec", ["jpeg", "h264"])
def test_cameras_are_seen_live_too(here: Path, codec: str) -> None:
    """As single pictures, whatever is recorded; with nothing recorded as well."""
    arguments = ["record.cameras=[chase]", "record.picture_size=[96,64]", f"record.codec={codec}"]
    arguments += ["record.every=0"] if codec == "jpeg" else []
    viewer = watched_play("/camera/chase", "/step", "/outcome", arguments=arguments)
    pictures = viewer.of("/camera/chase")
    assert len(pictures) >= len(viewer.of("/step"))
    assert {picture.format for picture in pictures} == {"jpeg"}
    assert Image.open(io.BytesIO(pictures[-1].data)).size == (96, 64)
    films = [list(open_recording(path).messages("/camera/chase")) for path in here.glob("played_episodes/*")]
    assert [film[0].content.format for film in films] == (["h264"] if codec == "h264" else [])
