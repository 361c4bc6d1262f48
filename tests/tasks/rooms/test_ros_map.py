"""Maps of ROS as rooms."""

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import yaml
from PIL import Image

from tasks.errors import TaskError
from tasks.rooms.flat.ros_map import read_ros_map
from tests.support.room_clearances import room_clearances

FREE, UNKNOWN, OCCUPIED = 254, 205, 0  # as map_saver writes them


def room_picture() -> npt.NDArray[np.uint8]:
    """70 × 90 cells: unknown, in it a wall of a cell around 50 × 70 free ones; a block in the upper left of them."""
    grey = np.full((70, 90), UNKNOWN, dtype=np.uint8)
    grey[9:61, 9:81] = OCCUPIED
    grey[10:60, 10:80] = FREE
    grey[15:20, 15:30] = OCCUPIED
    return grey


def write_map(folder: Path, grey: npt.NDArray[np.uint8], name: str = "room.pgm", **fields: Any) -> Path:
    Image.fromarray(grey).save(folder / name)
    return write_yaml(folder, {"image": name, "resolution": 0.05, "origin": [0.0, 0.0, 0.0]} | fields)


def write_yaml(folder: Path, content: object) -> Path:
    path = folder / "room.yaml"
    path.write_text(content if isinstance(content, str) else yaml.safe_dump(content))
    return path


def is_solid(path: Path, point: tuple[float, float]) -> bool:
    return bool(room_clearances(read_ros_map(path), [point])[0] == 0.0)


@pytest.mark.parametrize("name", ["room.pgm", "room.png"])
def test_cells_stand_where_the_map_has_them(tmp_path: Path, name: str) -> None:
    room = read_ros_map(write_map(tmp_path, room_picture(), name, origin=[-1.0, 2.0, 0.0]))
    # The floor: x from −0.5 to 3 m, y from 2.5 to 5 m; the block x from −0.25 to 0.5, y from 4.5 to 4.75 m.
    points = [(0.0, 4.6), (-0.52, 3.0), (0.0, 4.0), (1.5, 3.5), (2.5, 3.0)]
    assert room_clearances(room, points) == pytest.approx([0, 0, 0.5, 1.0, 0.5])
    assert room.omitted == ()


def test_a_yaw_turns_the_map_about_its_origin(tmp_path: Path) -> None:
    points = np.random.default_rng(0).uniform((0.0, 0.0), (4.5, 3.5), (100, 2))
    straight = room_clearances(read_ros_map(write_map(tmp_path, room_picture())), points)
    yaw = 2.1
    cos, sin = np.cos(yaw), np.sin(yaw)
    turned = points @ np.array([[cos, sin], [-sin, cos]]) + [5.0, -7.0]
    room = read_ros_map(write_map(tmp_path, room_picture(), origin=[5.0, -7.0, yaw]))
    assert room_clearances(room, turned) == pytest.approx(straight, abs=1e-9)


def test_unknown_cells_outside_are_solid_and_close_gaps(tmp_path: Path) -> None:
    grey = room_picture()
    grey[60, 30:40] = UNKNOWN  # a gap in the wall, to the outside
    path = write_map(tmp_path, grey)
    assert is_solid(path, (0.3, 1.0))
    assert is_solid(path, (1.75, 0.45))


def test_unknown_cells_in_the_midst_are_floor(tmp_path: Path) -> None:
    grey = room_picture()
    grey[30:40, 40:60] = UNKNOWN
    assert read_ros_map(write_map(tmp_path, grey)) == read_ros_map(write_map(tmp_path, room_picture()))


def test_unknown_cells_within_an_obstacle_are_filled_with_it(tmp_path: Path) -> None:
    grey = room_picture()
    grey[16:19, 16:29] = UNKNOWN
    assert read_ros_map(write_map(tmp_path, grey)) == read_ros_map(write_map(tmp_path, room_picture()))


def test_a_noisy_outside_takes_no_boxes(tmp_path: Path) -> None:
    grey = room_picture()
    noise = np.random.default_rng(0).choice(
        np.array([UNKNOWN, FREE, OCCUPIED], dtype=np.uint8), grey.shape, p=(0.7, 0.2, 0.1)
    )
    grey[:8], grey[62:], grey[:, :8], grey[:, 82:] = noise[:8], noise[62:], noise[:, :8], noise[:, 82:]
    assert len(read_ros_map(write_map(tmp_path, grey)).obstacles) <= 9


def test_thresholds_are_map_servers(tmp_path: Path) -> None:
    # (255 − 89)/255 = 0.651, (255 − 90)/255 = 0.647, of 0.65
    for value, expected in ((89, True), (90, False)):
        grey = room_picture()
        grey[40:50, 40:60] = value
        assert is_solid(write_map(tmp_path, grey), (2.5, 1.25)) == expected
        assert is_solid(write_map(tmp_path, grey, occupied_thresh=0.3), (2.5, 1.25))


def test_the_free_threshold_parts_floor_from_unknown_outside(tmp_path: Path) -> None:
    grey = room_picture()
    grey[grey == UNKNOWN] = 200  # 0.216
    solid = write_map(tmp_path, grey)
    assert is_solid(solid, (0.3, 1.0))
    assert not is_solid(write_map(tmp_path, grey, free_thresh=0.25), (0.3, 1.0))


@pytest.mark.parametrize("negate", [1, True, "yes"])
def test_a_negated_picture_has_white_obstacles(tmp_path: Path, negate: Any) -> None:
    path = write_map(tmp_path, 255 - room_picture(), negate=negate)
    negated = read_ros_map(path)
    assert negated == read_ros_map(write_map(tmp_path, room_picture()))


def test_mode_scale_takes_cells_between_the_thresholds_for_floor(tmp_path: Path) -> None:
    grey = room_picture()
    alpha = np.where(grey == UNKNOWN, 0, 255).astype(np.uint8)
    grey[40:50, 40:60] = 128
    rgba = np.dstack([grey, grey, grey, alpha])
    path = write_map(tmp_path, rgba, "room.png", mode="scale")
    assert not is_solid(path, (2.5, 1.25))
    assert is_solid(path, (0.3, 1.0))


def test_mode_raw_takes_100_for_occupied_and_more_for_unknown(tmp_path: Path) -> None:
    grey = room_picture()
    raw = np.select([grey == OCCUPIED, grey == FREE], [100, 0], 255).astype(np.uint8)
    raw[40:50, 40:60] = 99
    assert read_ros_map(write_map(tmp_path, raw, mode="raw")) == read_ros_map(write_map(tmp_path, room_picture()))


def test_a_transparent_pixel_is_unknown(tmp_path: Path) -> None:
    grey = room_picture()
    alpha = np.where(grey == UNKNOWN, 0, 255).astype(np.uint8)
    path = write_map(tmp_path, np.dstack([grey, grey, grey, alpha]), "room.png")
    transparent = read_ros_map(path)
    assert transparent == read_ros_map(write_map(tmp_path, room_picture()))


def test_a_picture_named_by_the_path_of_another_machine_lies_beside_the_map(tmp_path: Path) -> None:
    Image.fromarray(room_picture()).save(tmp_path / "room.pgm")
    fields = {"resolution": 0.05, "origin": [0.0, 0.0, 0.0]}
    far = read_ros_map(write_yaml(tmp_path, {"image": "/home/someone/maps/room.pgm"} | fields))
    assert far == read_ros_map(write_yaml(tmp_path, {"image": str(tmp_path / "room.pgm")} | fields))


def test_a_picture_outside_of_the_maps_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    Image.fromarray(room_picture()).save(tmp_path / "room.pgm")
    (tmp_path / "maps" / "link.pgm").symlink_to(tmp_path / "room.pgm")
    for name in ("../room.pgm", "link.pgm", "/elsewhere/link.pgm"):
        path = write_yaml(tmp_path / "maps", {"image": name, "resolution": 0.05, "origin": [0, 0, 0]})
        with pytest.raises(TaskError, match="image must lie in the map's folder"):
            read_ros_map(path)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"image": "none.pgm"}, "there is no file"),
        ({"image": "."}, "is not a file"),
        ({"image": ""}, "image must be the name of a picture"),
        ({"image": ["a"]}, "image must be the name of a picture"),
        ({"image": "a\0b"}, "image must be the name of a picture"),
        ({"image": "room.yaml"}, "is not a picture that can be read"),
        ({"resolution": 0}, "resolution must be from"),
        ({"resolution": -0.05}, "resolution must be from"),
        ({"resolution": "nan"}, "resolution must be from"),
        ({"resolution": 1e300}, "resolution must be from"),
        ({"resolution": 50}, "m wide is larger"),
        ({"resolution": [0.05]}, "resolution must be a number, not list"),
        ({"origin": [0]}, "origin must be three numbers"),
        ({"origin": [0, 0, 0, 0]}, "origin must be three numbers"),
        ({"origin": "here"}, "origin must be three numbers"),
        ({"origin": [0, "inf", 0]}, "a number of origin must be from"),
        ({"origin": [1e300, 0, 0]}, "a number of origin must be from"),
        ({"occupied_thresh": 2}, "occupied_thresh must be from 0 to 1"),
        ({"free_thresh": "low"}, "free_thresh must be a number, not 'low'"),
        ({"negate": 2}, "negate must be 0 or 1"),
        ({"mode": "tri"}, "mode must be one of trinary, scale, raw"),
        ({"mode": ["raw"]}, "mode must be one of trinary, scale, raw"),
    ],
)
def test_invalid_values_end_in_a_sentence(tmp_path: Path, fields: dict[str, Any], message: str) -> None:
    with pytest.raises(TaskError, match=message):
        read_ros_map(write_map(tmp_path, room_picture(), **fields))


@pytest.mark.parametrize("name", ["image", "resolution", "origin"])
def test_a_missing_field_is_named(tmp_path: Path, name: str) -> None:
    content = {"image": "room.pgm", "resolution": 0.05, "origin": [0, 0, 0]}
    del content[name]
    with pytest.raises(TaskError, match=f"it has no {name}; a map of ROS needs image, resolution, origin"):
        read_ros_map(write_yaml(tmp_path, content))


@pytest.mark.parametrize(
    "content", ["", "- 1", "image", "image: [", "image: *a", "image: &a [*a]", "a: " + "[" * 20000, "\x00", "a: b: c"]
)
def test_broken_yaml_is_refused(tmp_path: Path, content: str) -> None:
    with pytest.raises(TaskError, match=r"room.yaml(:| is)"):
        read_ros_map(write_yaml(tmp_path, content))


def test_a_map_without_a_free_cell_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TaskError, match="no free floor"):
        read_ros_map(write_map(tmp_path, np.full((20, 20), UNKNOWN, dtype=np.uint8)))
