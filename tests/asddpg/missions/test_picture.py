"""The picture of a mission, looked at where things must be."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from asddpg.missions.log import MissionLog
from asddpg.missions.picture import draw_mission
from tasks.physics import Physics
from tasks.room_geometry.obstacles import Obstacles
from tasks.scene.loading import scene_path
from tests.support.missions import Pose, log_of

Colour = tuple[int, int, int]
WHITE, WALL, YELLOW = (255, 255, 255), (70, 74, 80), (250, 205, 60)
BLUE, RED, BLACK, GREEN = (31, 119, 180), (214, 39, 40), (20, 20, 20), (44, 160, 44)
# The walls of nav_simple end at ±4.1 m, and 0.3 m are left around them; above is a strip for the title, 54 px.
SCALE, EDGE, STRIP = 1200 / 8.8, 4.4, 54
TARGETS = ((-3.0, 3.0), (3.0, 3.0))
WITHIN = 0.3


def at(picture: Image.Image, x: float, y: float) -> Colour:
    """The colour at a place of the room, metres."""
    found = picture.getpixel((round((x + EDGE) * SCALE), round((EDGE - y) * SCALE + STRIP)))
    assert isinstance(found, tuple)
    red, green, blue = found
    return red, green, blue


def is_like(found: Colour, colour: Colour) -> bool:
    return max(abs(a - b) for a, b in zip(found, colour, strict=True)) < 25


def draw(folder: Path, log: MissionLog) -> Image.Image:
    """In nav_simple, whose map lacks `north`."""
    model = Physics.from_xml_path(str(scene_path("nav_simple"))).model.ptr
    picture = draw_mission(log, Obstacles.from_model(model), Obstacles.from_model(model, ["north"]), WITHIN)
    picture.write(folder / "mission.png", "mission 1: all targets reached")
    return Image.open(folder / "mission.png").convert("RGB")


def straight(y: float, estimated_y: float) -> list[tuple[Pose, Pose]]:
    """From x = −3 to 3 m."""
    return [((x, y, 0.0), (x, estimated_y, 0.0)) for x in np.linspace(-3.0, 3.0, 61).tolist()]


@pytest.fixture(scope="module")
def picture(tmp_path_factory: pytest.TempPathFactory) -> Image.Image:
    return draw(tmp_path_factory.mktemp("picture"), log_of(straight(-2.5, -3.0), TARGETS))


def test_the_room_is_drawn_with_what_the_map_lacks_in_yellow(picture: Image.Image) -> None:
    assert is_like(at(picture, 0.0, 1.25), YELLOW)
    for place in ((0.0, -1.25), (-1.75, 0.0), (1.75, 0.9), (4.05, 2.0), (0.0, -4.05)):
        assert is_like(at(picture, *place), WALL), place
    for place in ((0.0, 0.0), (0.0, 1.6), (2.1, 0.0), (4.3, 0.0), (0.6, 1.25)):
        assert is_like(at(picture, *place), WHITE), place


def test_targets_are_blue_circles_of_the_radius_that_counts(picture: Image.Image) -> None:
    for x, y in TARGETS:
        for dx, dy in ((WITHIN, 0.0), (-WITHIN, 0.0), (0.0, WITHIN), (0.0, -WITHIN)):
            rim = [at(picture, x + share * dx, y + share * dy) for share in (0.92, 0.95, 0.98)]
            assert any(is_like(found, BLUE) for found in rim)
            assert is_like(at(picture, x + 1.2 * dx, y + 1.2 * dy), WHITE)
        assert is_like(at(picture, x + 0.24, y), WHITE)


def test_the_true_path_is_red_and_the_estimated_one_is_dashed(picture: Image.Image) -> None:
    xs = np.arange(-2.7, 3.0, 0.02).tolist()
    assert all(is_like(at(picture, x, -2.5), RED) for x in xs)
    dashes = [is_like(at(picture, x, -3.0), BLACK) for x in xs]
    gaps = [is_like(at(picture, x, -3.0), WHITE) for x in xs]
    assert 0.3 < np.mean(dashes) < 0.7
    assert 0.3 < np.mean(gaps) < 0.7
    assert is_like(at(picture, -3.0, -2.4), GREEN)
    assert not any(is_like(at(picture, 2.9, -2.5 + dy), RED) for dy in (-0.15, 0.15)), "no cross: nothing was touched"


def test_a_touch_has_a_cross_where_it_was(tmp_path: Path) -> None:
    infos = [{"touched": ("bin",) if step in (29, 30) else ()} for step in range(60)]  # the poses of 30 and 31
    found = draw(tmp_path, log_of(straight(-2.5, -2.5), TARGETS, infos))
    for dx, dy in ((0.15, 0.15), (-0.15, 0.15), (0.15, -0.15), (-0.15, -0.15)):
        assert is_like(at(found, 0.0 + dx, -2.5 + dy), RED)
        assert not is_like(at(found, 3.0 + dx, -2.5 + dy), RED)


def test_a_moved_target_is_drawn_where_it_was_moved_to(tmp_path: Path) -> None:
    found = draw(tmp_path, log_of(straight(-2.5, -2.5), TARGETS, [{"goal": (-3.0, 2.0)}] * 60))
    rims = {y: [at(found, -3.0 + WITHIN * share, y) for share in (0.92, 0.95, 0.98)] for y in (2.0, 3.0)}
    assert {y: any(is_like(colour, BLUE) for colour in rim) for y, rim in rims.items()} == {2.0: True, 3.0: False}


def test_title_and_legend_stand_in_their_strips(picture: Image.Image) -> None:
    assert picture.size == (1200, round(8.8 * SCALE + 2 * STRIP))
    pixels = np.asarray(picture)
    assert (pixels[:STRIP] < 128).any(), "a title"
    legend = pixels[-STRIP:].reshape(-1, 3)
    for colour in (WALL, YELLOW, BLUE, RED):
        assert (np.abs(legend.astype(int) - colour).max(axis=1) < 10).any(), colour


def test_a_robot_that_never_moved_is_drawn_too(tmp_path: Path) -> None:
    still: list[tuple[Pose, Pose]] = [((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))]
    assert is_like(at(draw(tmp_path, log_of(still, TARGETS)), 0.1, 0.0), GREEN)
