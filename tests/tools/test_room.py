"""What became of a room: its picture, what was taken of it, and its scene."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from PIL import Image

from asddpg.missions.room_picture import WALL
from tasks.rooms.reading import find_room
from tasks.rooms.room import Room
from tasks.rooms.scene import compile_room
from tasks.rooms.solid.mjcf_room import read_mjcf
from tests.support.entry_point import ended
from tests.support.room_files import write_maze, write_picture, write_world
from tools import room
from tools.room import _FREE, _GOAL, _START

STATUE = (
    "<model name='statue'><static>1</static><link name='l'><collision name='c'><geometry>"
    "<mesh><uri>nowhere.dae</uri></mesh></geometry></collision></link></model>"
    "<model name='ball'><pose>1 2 0.2 0 0 0</pose><link name='l'><collision name='c'><geometry>"
    "<sphere><radius>0.2</radius></sphere></geometry></collision></link></model></world>"
)


def assert_same_obstacles(one: Room, other: Room) -> None:
    """The same but for their names, to the digits of a file of MJCF."""
    for each, twin in zip(one.obstacles, other.obstacles, strict=True):
        assert each.shape is twin.shape
        assert each.mass == pytest.approx(twin.mass)
        numbers, others = ([*solid.position, *solid.size, *solid.quaternion] for solid in (each, twin))
        assert numbers == pytest.approx(others, abs=2e-4)


def test_it_lists_what_was_taken_and_what_was_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    world = tmp_path / write_world(tmp_path)
    world.write_text(world.read_text().replace("</world>", STATUE))
    room.main(["room.world"])
    said = capsys.readouterr().out.splitlines()
    assert said[0] == "taken: 5 box, 1 movable sphere"
    assert said[1].startswith("not taken: ")
    assert "statue" in said[1]
    assert said[2].startswith("4.2 × 3.2 m, the robot begins at (")
    assert said[3].startswith("written to room_room.png and room_scene.xml; ")
    assert said[3].endswith(" -m asddpg.play agent=move_base task=room.world drives in it")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["room.world", "room_room.png", "room_scene.xml"]


def test_the_picture_has_its_colours_at_computed_places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    maze = tmp_path / write_maze(tmp_path)
    maze.write_text("cell 0.5\n" + maze.read_text().split("\n", 1)[1].replace("#        #", "#S      G#", 1))
    room.main(["maze.txt", "picture=seen.png"])
    drawn = np.asarray(Image.open("seen.png").convert("RGB")).astype(int)
    # 5 × 4 m and 0.3 m around them in 1200 px; the title above takes 0.045 of it.
    scale = 1200 / 5.6

    def colour(x: float, y: float) -> list[int]:
        column, row = (x + 0.3) * scale, 0.045 * 1200 + (4.3 - y) * scale
        return list(drawn[round(row), round(column)].tolist())

    walls, post = [(0.25, 2.0), (2.5, 0.25), (4.75, 3.0), (2.5, 3.75)], [(2.1, 2.0), (2.9, 1.6)]
    assert [colour(*place) for place in walls + post] == [list(WALL)] * 6
    assert [colour(*place) for place in [(1.2, 1.2), (3.8, 1.2), (1.2, 2.6)]] == [list(_FREE)] * 3
    assert colour(0.75, 3.25) == list(_START)
    assert colour(4.25 + 0.3 - 0.02, 3.25) == list(_GOAL)
    assert [colour(*place) for place in [(0.6, 1.5), (1.8, 2.0), (-0.2, 2.0)]] == [
        [255] * 3
    ] * 3  # no robot turns there


@pytest.mark.parametrize("name", ["clutter:2", "legs:0", "rooms:1"])
def test_the_scene_opens_in_mujoco_and_reads_back_as_the_same_room(name: str, tmp_path: Path) -> None:
    scene = tmp_path / "scene.xml"
    room.main([name, f"picture={tmp_path / 'a.png'}", f"mjcf={scene}"])
    written, expected = mujoco.MjModel.from_xml_path(str(scene)), compile_room(find_room(name))
    for field in ("geom_type", "geom_size", "geom_pos", "geom_quat", "geom_group", "body_pos", "cam_pos"):
        np.testing.assert_allclose(getattr(written, field), getattr(expected, field), atol=1e-4)
    assert_same_obstacles(read_mjcf(scene), find_room(name))


def test_a_scene_with_a_fence_a_movable_thing_and_a_hull_reads_back(tmp_path: Path) -> None:
    source, scene = tmp_path / "source.xml", tmp_path / "scene.xml"
    source.write_text(
        "<mujoco><asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1'/></asset><worldbody>"
        "<geom type='mesh' mesh='m' pos='3 0 0'/><body name='ball' pos='0 2 0.2'><freejoint/>"
        "<geom type='sphere' size='0.2' mass='1.5'/></body></worldbody></mujoco>"
    )
    room.main([str(source), f"picture={tmp_path / 'a.png'}", f"mjcf={scene}"])
    before, after = read_mjcf(source), read_mjcf(scene)
    fixed = {each.name for each in after.obstacles} - {each.name for each in before.obstacles}
    assert fixed == {"fence_east", "fence_north", "fence_west", "fence_south"}
    for one in before.obstacles:
        other = next(each for each in after.obstacles if each.name == one.name)
        assert (one.shape, one.mass) == (other.shape, other.mass)
        assert np.array(one.position) == pytest.approx(np.array(other.position), abs=1e-4)


def test_the_rooms_own_picture_is_not_overwritten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    name = write_picture(tmp_path)
    before = (tmp_path / "plan.png").read_bytes()
    room.main([name])
    assert (tmp_path / "plan.png").read_bytes() == before
    assert (tmp_path / "plan_room.png").is_file()


@pytest.mark.parametrize("arguments", [["foo"], ["nav_empty"], ["none.txt"], [], ["open:0", "picture=a_file/b.png"]])
def test_a_mistake_is_a_sentence(arguments: list[str]) -> None:
    found = ended(room.main, arguments)
    assert (found.status, found.made) == (2, [])
    assert found.said.startswith("error: ")
    assert found.said.count("\n") == 1
