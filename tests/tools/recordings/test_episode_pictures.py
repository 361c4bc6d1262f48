"""Pictures of recorded episodes."""

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import tasks
from asddpg.build import navigation_env
from asddpg.command_line import train_config
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Decision, Driver, Observation
from asddpg.errors import UserError
from asddpg.recording.files.reading import open_recording
from asddpg.recording.recorder import BATCH_STEPS, Provenance, Recorder, Selection, every_nth
from asddpg.runs.run_folder import config_text
from tasks.errors import TaskError
from tests.asddpg.recording.test_recording import environment_of
from tools import contact_sheet, episode_frame, episode_map, episode_plot
from tools.drawing.map_view import MapView
from tools.recordings.driven_paths import read_path
from tools.recordings.episode_signals import read_signals
from tools.recordings.episode_states import EpisodeStates

STEPS = 12


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two episodes in nav_complex, driven by policy and controller in turn, four steps each."""
    environment = environment_of("nav_complex")
    settings = config_text(train_config(["task=nav_complex"]), {})
    folder = tmp_path_factory.mktemp("recorded")
    facts = {"task": "nav_complex"}
    recorder = Recorder(
        folder, navigation_env(environment), Provenance(settings, facts), Selection(every_nth(1)), print
    )
    for _ in range(2):
        drivers = itertools.cycle([*[Driver.POLICY] * 4, *[Driver.CONTROLLER] * 4])
        action = np.array([0.3, 0.4], dtype=np.float32)
        driver = FixedDriver(lambda _: Decision(action, next(drivers), q_policy=1.0, q_controller=0.5, value=0.7))  # noqa: B023
        run_episode(environment, driver, (recorder,), max_steps=STEPS)
    return folder


@pytest.fixture
def file(folder: Path) -> str:
    return str(sorted(folder.iterdir())[0])


def picture(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path)).astype(int)


# States -----------------------------------------------------------------------------------------------------------


def test_an_episode_run_again_goes_through_the_recorded_states(file: str) -> None:
    states = EpisodeStates(open_recording(file))
    counts = []
    for count, step in states:
        counts.append(count)
        assert step is None or states.physics.state_digest() == step["digest"]
    assert counts == [*range(STEPS + 1)]
    assert states.outcome == "cut"


def test_an_episode_that_goes_another_way_is_noted_once(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    states = EpisodeStates(open_recording(file))
    states.steps[3]["digest"] += 1
    states.steps[5]["digest"] += 1
    assert len([*states]) == STEPS + 1
    (note,) = capsys.readouterr().err.splitlines()
    assert "goes another way from step 4 on" in note


# Frames -----------------------------------------------------------------------------------------------------------


def test_a_frame_shows_the_given_moment(file: str, tmp_path: Path) -> None:
    def frame(*arguments: str) -> np.ndarray:
        episode_frame.main([file, "size=96x64", "caption=false", f"file={tmp_path / 'frame.png'}", *arguments])
        return picture(tmp_path / "frame.png")

    last = frame("camera=onboard")
    assert last.shape == (64, 96, 3)
    assert np.array_equal(last, frame("camera=onboard", f"step={STEPS}"))
    assert np.array_equal(last, frame("camera=onboard", f"time={STEPS * 0.2}"))
    assert np.abs(last - frame("camera=onboard", "step=2")).mean() > 1
    states = EpisodeStates(open_recording(file))
    states.go_to(2)
    assert np.array_equal(frame("step=2", "camera=free"), states.physics.render(64, 96, "free"))


def test_a_frame_s_file_is_named_after_what_it_shows(
    file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    episode_frame.main([file, "step=0", "size=64x48"])
    assert capsys.readouterr().out == f"written to {Path(file).stem}_chase_0.png\n"
    assert (tmp_path / f"{Path(file).stem}_chase_0.png").is_file()


# Sheets -----------------------------------------------------------------------------------------------------------


def test_a_sheet_of_one_recording_shows_it_over_time(file: str, tmp_path: Path) -> None:
    contact_sheet.main([file, "frames=6", "columns=3", "size=64x48", f"file={tmp_path / 'sheet.png'}"])
    height, width, _ = picture(tmp_path / "sheet.png").shape
    assert width == 3 * 64 + 2 * contact_sheet.GAP
    assert height > 2 * 48  # each with its caption


def test_a_sheet_of_a_folder_shows_how_each_ended(folder: Path, tmp_path: Path) -> None:
    contact_sheet.main([str(folder), "size=64x48", f"file={tmp_path / 'sheet.png'}"])
    assert picture(tmp_path / "sheet.png").shape[1] == 2 * 64 + contact_sheet.GAP


def test_a_recording_that_was_cut_off_is_shown_as_far_as_it_goes(tmp_path: Path) -> None:
    environment = environment_of("nav_complex")
    settings = config_text(train_config(["task=nav_complex"]), {})
    provenance = Provenance(settings, {"task": "nav_complex"})
    recorder = Recorder(tmp_path, navigation_env(environment), provenance, Selection(every_nth(1)), print)
    parts: list[bytes] = []

    def decide(_: Observation) -> Decision:
        parts[:] = [path.read_bytes() for path in tmp_path.glob("*.part")]
        return Decision(np.zeros(2, dtype=np.float32), Driver.POLICY)

    run_episode(environment, FixedDriver(decide), (recorder,), max_steps=BATCH_STEPS + 1)
    (with_steps,) = parts
    before_first_step = with_steps[: with_steps.index(b'{"step":0')]
    for name, content in (("begun", before_first_step), ("without_outcome", with_steps[:9000])):
        cut = tmp_path / f"{name}.mcap.part"
        cut.write_bytes(content)
        assert EpisodeStates(open_recording(cut)).outcome == "running"
        episode_frame.main([str(cut), "size=64x48", f"file={tmp_path / 'frame.png'}"])
        episode_map.main([str(cut), "size=200", f"file={tmp_path / 'map.png'}"])
        with pytest.raises(UserError, match="holds no steps to plot"):
            episode_plot.main([str(cut)])


# Maps -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("goal", [(0.0, 0.0), (3.5, 3.0), (-3.0, 3.6), (3.4, -3.5)])
def test_a_place_is_at_its_pixels(goal: tuple[float, float]) -> None:
    """The green goal, wherever it is: no perspective shifts it."""
    physics = tasks.load("nav_empty", random=0).physics
    view = MapView(0.2, -0.1, 9.0, 8.6)
    with physics.reset_context():
        physics.set_goal(*goal)
        physics.data.ptr.qpos[:2] = (0.0, -3.0)
    seen = view.render(physics.model.ptr, physics.data.ptr, pixels_per_metre=40).astype(int)
    assert seen.shape == (344, 360, 3)
    rows, columns = np.nonzero((seen[..., 1] > seen[..., 0] + 40) & (seen[..., 1] > seen[..., 2] + 40))
    left, _, _, top = view.extent
    expected = (goal[0] - left) * 40, (top - goal[1]) * 40
    assert (columns.mean() + 0.5, rows.mean() + 0.5) == pytest.approx(expected, abs=0.5)
    assert len(rows) == pytest.approx(np.pi * (0.3 * 40) ** 2, rel=0.05)


def test_the_path_is_cut_where_the_driver_changes(file: str) -> None:
    path = read_path(EpisodeStates(open_recording(file)))
    assert [(driver, len(places)) for driver, places in path.stretches()] == [
        ("policy", 5),
        ("controller", 5),
        ("policy", 5),
    ]
    (_, first), (_, second), _ = path.stretches()
    assert first[-1].tolist() == second[0].tolist()
    assert 0.3 < path.length() < 0.3 * 0.2 * STEPS


@pytest.mark.parametrize("of_all", [False, True])
def test_a_map_shows_the_paths_in_the_drivers_colours(file: str, folder: Path, tmp_path: Path, of_all: bool) -> None:
    episode_map.main([str(folder) if of_all else file, "size=800", f"file={tmp_path / 'map.png'}"])
    seen = picture(tmp_path / "map.png")
    for colour in ((31, 119, 180), (255, 127, 13)):
        assert (np.abs(seen[..., :3] - colour).max(axis=2) < 12).sum() > 20


# Plots ------------------------------------------------------------------------------------------------------------


def test_a_plot_s_signals_are_those_of_the_recording(file: str, tmp_path: Path) -> None:
    signals = read_signals(open_recording(file))
    assert signals.ends[-1] == pytest.approx(STEPS * 0.2)
    assert signals.by_name["v"] == pytest.approx([0.3] * STEPS)
    assert signals.by_name["q_controller"].tolist() == [0.5] * STEPS
    assert signals.driven.shape == (STEPS + 1, 2)
    assert signals.driven[-1] == pytest.approx((0.3, 0.4), abs=0.05)
    assert not {"noise_v", "noise_omega"} & set(signals.by_name)
    assert "time" in signals.terms
    episode_plot.main([file, f"file={tmp_path / 'plot.png'}"])
    assert picture(tmp_path / "plot.png").shape[0] > 500


# Errors ----------------------------------------------------------------------------------------------------------


Main = Callable[[Sequence[str]], None]


@pytest.mark.parametrize(
    ("main", "arguments", "sentence"),
    [
        (episode_frame.main, ["step=99"], "has 12 steps, 2.4 s; there is no step 99"),
        (episode_frame.main, ["step=1.5"], "step must be a whole number or null, not '1.5'"),
        (episode_frame.main, ["time=soon"], "time must be a number or null, not 'soon'"),
        (episode_frame.main, ["time=1", "step=5"], "give one of them"),
        (episode_frame.main, ["camera=side", "size=64x48"], "no camera 'side'; there are top, chase, onboard, free"),
        (episode_frame.main, ["size=5"], "size must be as in 1280x800"),
        (episode_frame.main, ["colour=red"], "no option 'colour'; there are step, time, camera, file, size, caption"),
        (episode_frame.main, ["caption=maybe"], "caption must be true or false, not 'maybe'"),
        (contact_sheet.main, ["columns=many"], "columns must be a whole number or null, not 'many'"),
        (contact_sheet.main, ["file=sheet.txt"], r"a path that ends in \.png or \.jpg, not sheet\.txt"),
        (episode_map.main, ["size=9"], "size must be from 200 to 4000, not 9"),
        (episode_map.main, ["file=map.jpg"], r"a path that ends in \.png, not map\.jpg"),
        (episode_plot.main, ["file=plot.pdf"], r"a path that ends in \.png, not plot\.pdf"),
    ],
)
def test_invalid_arguments_are_one_sentence(main: Main, arguments: list[str], sentence: str, file: str) -> None:
    with pytest.raises((UserError, TaskError), match=sentence):
        main([file, *arguments])


def test_recordings_that_are_not_there_are_one_sentence(folder: Path, tmp_path: Path) -> None:
    for main in (episode_frame.main, contact_sheet.main, episode_map.main, episode_plot.main):
        with pytest.raises(UserError, match="RECORDINGS?…? is missing: (a recording|recordings), or"):
            main([])
        with pytest.raises(UserError, match="there is no file or folder"):
            main([str(tmp_path / "none.mcap")])
        with pytest.raises(UserError, match=r"there are no recordings \(\*\.mcap\) in"):
            main([str(tmp_path)])
    for single in (episode_frame.main, episode_plot.main):
        with pytest.raises(UserError, match="name one recording, not 2"):
            single([str(folder)])
    with pytest.raises(UserError, match="frames= is for one recording"):
        contact_sheet.main([str(folder), "frames=3"])


def test_a_place_that_cannot_be_written_is_one_sentence(file: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be written"):
        episode_frame.main([file, "step=0", "size=64x48", f"file={tmp_path}/none/frame.png"])


def test_scan_and_path_are_drawn_where_they_are(tmp_path: Path, folder: Path) -> None:
    first, *_ = sorted(folder.iterdir())
    pictures = {}
    for overlays in ("", "scan", "path", "scan,path"):
        file = tmp_path / f"{overlays or 'nothing'}.png"
        arguments = [f"file={file}", "step=10", "size=320x240", "caption=false", "camera=top"]
        episode_frame.main([str(first), *arguments, *([f"show={overlays}"] if overlays else [])])
        pictures[overlays] = np.asarray(Image.open(file)).astype(int)
    redder = {name: float(np.mean(p[..., 0] - p[..., 2])) for name, p in pictures.items()}
    assert redder["scan"] > redder[""]
    assert redder["scan,path"] > redder["path"]
    assert np.any(pictures["path"] != pictures[""])
    with pytest.raises(UserError, match=r"show must be some of scan, path, not \['scam'\]"):
        episode_frame.main([str(first), "show=scam"])
