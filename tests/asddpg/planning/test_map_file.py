"""Map files: as written so read, and as map_server of ROS reads them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from PIL import Image

from asddpg.errors import UserError
from asddpg.planning.map_file import read_map, write_map
from asddpg.planning.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid


def write_picture(folder: Path, rows: list[list[int]], name: str = "room.png", **fields: Any) -> Path:
    """A picture of these grey values, and its YAML file."""
    Image.fromarray(np.array(rows, dtype=np.uint8)).save(folder / name)
    return write_description(folder, {"image": name, "resolution": 0.1, "origin": [0.0, 0.0, 0.0]} | fields)


def write_description(folder: Path, content: object) -> Path:
    path = folder / "room.yaml"
    path.write_text(content if isinstance(content, str) else yaml.safe_dump(content))
    return path


def test_a_map_is_read_as_it_was_written(tmp_path: Path) -> None:
    cells = np.random.default_rng(0).choice(np.array([UNKNOWN, FREE, OCCUPIED], dtype=np.int8), (7, 12))
    grid = OccupancyGrid(cells, 0.05, (-4.15, 2.3))
    write_map(grid, tmp_path / "room.yaml")
    found = read_map(tmp_path / "room.yaml")
    assert found.cells.tolist() == cells.tolist()
    assert found.cells.dtype == np.int8
    assert (found.resolution, found.origin) == (0.05, (-4.15, 2.3))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["room.png", "room.yaml"]


def test_numbers_of_numpy_are_written_too(tmp_path: Path) -> None:
    low = np.array([-1.5, 2.0])
    grid = OccupancyGrid(np.zeros((2, 2), dtype=np.int8), np.float64(0.05), (low[0], low[1]))
    write_map(grid, tmp_path / "room.yaml")
    found = read_map(tmp_path / "room.yaml")
    assert (found.resolution, found.origin) == (0.05, (-1.5, 2.0))


def test_the_file_is_what_map_saver_writes(tmp_path: Path) -> None:
    grid = OccupancyGrid(np.array([[UNKNOWN, FREE], [OCCUPIED, FREE]], dtype=np.int8), 0.05, (-1.0, 2.0))
    write_map(grid, tmp_path / "room.yaml")
    assert yaml.safe_load((tmp_path / "room.yaml").read_text()) == {
        "image": "room.png",
        "resolution": 0.05,
        "origin": [-1.0, 2.0, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }
    with Image.open(tmp_path / "room.png") as picture:
        assert np.asarray(picture).tolist() == [[0, 254], [205, 254]]  # the top row is the one of the largest y


def test_a_written_map_replaces_an_earlier_one(tmp_path: Path) -> None:
    for value in (FREE, OCCUPIED):
        write_map(OccupancyGrid.filled((0.0, 0.0), (1.0, 1.0), 0.5, value), tmp_path / "room.yaml")
    assert read_map(tmp_path / "room.yaml").occupied.all()


def test_the_first_row_of_a_picture_has_the_largest_y(tmp_path: Path) -> None:
    grid = read_map(write_picture(tmp_path, [[0, 254, 254], [254, 254, 254]]))
    assert grid.occupied.tolist() == [[False] * 3, [True, False, False]]
    assert grid.to_points((1, 0)) == pytest.approx((0.05, 0.15))


def test_grey_values_are_told_apart_by_map_servers_thresholds(tmp_path: Path) -> None:
    # (255 − 89)/255 = 0.651 and (255 − 90)/255 = 0.647, of 0.65; (255 − 205)/255 = 0.1961 and 0.1922, of 0.196
    grid = read_map(write_picture(tmp_path, [[0, 89, 90, 205, 206, 254, 255]]))
    assert grid.cells.tolist() == [[OCCUPIED, OCCUPIED, UNKNOWN, UNKNOWN, FREE, FREE, FREE]]


def test_a_negated_picture_has_white_obstacles(tmp_path: Path) -> None:
    # 166/255 = 0.651, 165/255 = 0.647; 50/255 = 0.1961, 49/255 = 0.1922
    grid = read_map(write_picture(tmp_path, [[255, 166, 165, 50, 49, 0]], negate=1))
    assert grid.cells.tolist() == [[OCCUPIED, OCCUPIED, UNKNOWN, UNKNOWN, FREE, FREE]]


def test_thresholds_of_the_file_count(tmp_path: Path) -> None:
    # Darkness 0.502, 0.498, 0.102 and 0.098
    grid = read_map(write_picture(tmp_path, [[127, 128, 229, 230]], occupied_thresh=0.5, free_thresh=0.1))
    assert grid.cells.tolist() == [[OCCUPIED, UNKNOWN, UNKNOWN, FREE]]


@pytest.mark.parametrize("name", ["room.pgm", "room.bmp"])
def test_the_picture_may_have_other_formats(tmp_path: Path, name: str) -> None:
    assert read_map(write_picture(tmp_path, [[0, 254]], name)).cells.tolist() == [[OCCUPIED, FREE]]


def test_a_coloured_picture_is_read_by_its_brightness(tmp_path: Path) -> None:
    path = write_picture(tmp_path, [[0]])
    Image.fromarray(np.array([[[0, 0, 0], [255, 255, 255]]], dtype=np.uint8)).save(tmp_path / "room.png")
    assert read_map(path).cells.tolist() == [[OCCUPIED, FREE]]


def test_the_picture_lies_beside_its_description_or_where_that_says(tmp_path: Path) -> None:
    (tmp_path / "pictures").mkdir()
    write_picture(tmp_path, [[0, 254]], "pictures/room.png")
    assert read_map(tmp_path / "room.yaml").shape == (1, 2)
    write_picture(tmp_path, [[0, 254]], "pictures/room.png", image=str(tmp_path / "pictures/room.png"))
    assert read_map(tmp_path / "room.yaml").shape == (1, 2)


DESCRIPTION = {"image": "room.png", "resolution": 0.1, "origin": [0.0, 0.0, 0.0]}


def without(name: str) -> dict[str, object]:
    return {field: value for field, value in DESCRIPTION.items() if field != name}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("image: [room.png", "is not the YAML file of a map"),
        ("a\x00b", "is not the YAML file of a map"),
        ("", "has no image"),
        ("just words", "has no image"),
        ("- image\n- resolution\n- origin\n", "has no image"),
        (without("image"), "has no image"),
        (without("resolution"), "has no resolution"),
        (without("origin"), "has no origin; it needs image, resolution, origin"),
        (DESCRIPTION | {"resolution": "fine"}, "resolution is a number, and origin three"),
        (DESCRIPTION | {"resolution": None}, "resolution is a number, and origin three"),
        (DESCRIPTION | {"origin": [0.0, 0.0]}, "resolution is a number, and origin three"),
        (DESCRIPTION | {"origin": 3.0}, "resolution is a number, and origin three"),
        (DESCRIPTION | {"origin": "here"}, "resolution is a number, and origin three"),
        (DESCRIPTION | {"resolution": 0.0}, "resolution must be above 0"),
        (DESCRIPTION | {"resolution": -0.1}, "resolution must be above 0"),
        (DESCRIPTION | {"resolution": float("nan")}, "resolution must be above 0"),
        (DESCRIPTION | {"resolution": float("inf")}, "resolution must be above 0"),
        (DESCRIPTION | {"origin": [float("inf"), 0.0, 0.0]}, "origin finite"),
        (DESCRIPTION | {"origin": [0.0, float("nan"), 0.0]}, "origin finite"),
        (DESCRIPTION | {"origin": [0.0, 0.0, 0.5]}, "turned by 0.5 rad"),
    ],
)
def test_a_wrong_description_is_an_error_in_one_sentence(tmp_path: Path, content: object, message: str) -> None:
    write_picture(tmp_path, [[0, 254]])
    path = write_description(tmp_path, content)
    with pytest.raises(UserError, match=message) as caught:
        read_map(path)
    assert "room.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_description_that_is_no_text_is_an_error_in_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "room.yaml"
    path.write_bytes(b"\xfa\x81 image")
    with pytest.raises(UserError, match="is not the YAML file of a map"):
        read_map(path)


def test_a_file_that_is_no_picture_is_an_error_in_one_sentence(tmp_path: Path) -> None:
    path = write_picture(tmp_path, [[0, 254]])
    (tmp_path / "room.png").write_text("not a picture")
    with pytest.raises(UserError, match=r"room\.png is not a picture that can be read"):
        read_map(path)


def test_a_cut_off_picture_is_an_error_in_one_sentence(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).integers(256, size=(100, 100)).tolist()
    for name in ("room.png", "room.pgm"):
        path = write_picture(tmp_path, noise, name)
        whole = (tmp_path / name).read_bytes()
        (tmp_path / name).write_bytes(whole[: len(whole) // 2])
        with pytest.raises(UserError, match="is not a picture that can be read"):
            read_map(path)


def test_a_file_that_is_missing_stays_an_error_of_the_system(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        read_map(tmp_path / "room.yaml")
    path = write_picture(tmp_path, [[0, 254]], image="other.png")
    with pytest.raises(FileNotFoundError):
        read_map(path)


@pytest.mark.parametrize(("name", "ending"), [("room.png", r"\.png"), ("room", "nothing"), ("room.yml", r"\.yml")])
def test_a_map_is_written_under_no_other_ending(tmp_path: Path, name: str, ending: str) -> None:
    with pytest.raises(UserError, match=rf"ends in \.yaml, not in {ending}"):
        write_map(OccupancyGrid.filled((0.0, 0.0), (1.0, 1.0), 0.5), tmp_path / name)
    assert not list(tmp_path.iterdir())
