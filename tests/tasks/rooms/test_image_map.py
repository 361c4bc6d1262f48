"""Rooms drawn as pictures."""

import os
import struct
import zlib
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from tasks.errors import TaskError
from tasks.rooms.flat.image_map import read_image
from tests.support.room_clearances import room_clearances


def room_picture() -> npt.NDArray[np.uint8]:
    """40 × 60 pixels: a frame of one, and a block in the upper right."""
    grey = np.full((40, 60), 255, dtype=np.uint8)
    grey[[0, -1]], grey[:, [0, -1]] = 0, 0
    grey[5:10, 45:55] = 0
    return grey


def write(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("suffix", ["png", "pgm", "bmp", "gif", "tiff", "webp"])
def test_dark_is_wall_and_rows_go_down(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"room.{suffix}"
    Image.fromarray(room_picture()).save(path, lossless=True)
    room = read_image(path, 0.1)
    assert len(room.obstacles) == 5
    # The block: x from 4.5 to 5.5 m, y from 3.0 to 3.5 m.
    points = [(5.0, 3.2), (0.05, 2.0), (3.0, 0.05), (5.0, 2.5), (4.0, 3.2), (2.0, 1.6)]
    assert room_clearances(room, points) == pytest.approx([0, 0, 0, 0.5, 0.5, 1.5])


def test_a_scale_stretches_the_room(tmp_path: Path) -> None:
    Image.fromarray(room_picture()).save(tmp_path / "room.png")
    points = np.random.default_rng(0).uniform((0, 0), (6, 4), (50, 2))
    once, twice = (read_image(tmp_path / "room.png", scale) for scale in (0.1, 0.2))
    assert room_clearances(twice, 2 * points) == pytest.approx(2 * room_clearances(once, points))


@pytest.mark.parametrize("mode", ["1", "L", "P", "RGB", "RGBA", "LA", "I;16"])
def test_pictures_of_every_mode_are_the_same_room(tmp_path: Path, mode: str) -> None:
    plain = Image.fromarray(room_picture())
    picture = Image.fromarray(room_picture().astype(np.uint16) * 257) if mode == "I;16" else plain.convert(mode)
    plain.save(tmp_path / "plain.png")
    picture.save(tmp_path / "room.png")
    assert read_image(tmp_path / "room.png", 0.1) == read_image(tmp_path / "plain.png", 0.1)


def test_colours_count_by_their_mean_and_transparent_pixels_are_floor(tmp_path: Path) -> None:
    pixels = np.dstack([room_picture()] * 3 + [np.full((40, 60), 255, dtype=np.uint8)])
    pixels[5:10, 45:55] = (0, 0, 255, 255)  # blue is dark
    pixels[20:25, 45:55] = (255, 255, 0, 255)  # yellow is not
    pixels[30:35, 45:55] = (0, 0, 0, 0)
    Image.fromarray(pixels).save(tmp_path / "room.png")
    found = room_clearances(read_image(tmp_path / "room.png", 0.1), [(5.0, 3.25), (5.0, 1.75), (5.0, 0.75)])
    assert found.tolist() == pytest.approx([0.0, 0.9, 0.65])


@pytest.mark.parametrize("scale", [0.0, -0.1, float("nan"), float("inf"), 1e-300, 1e300, 20.0])
def test_scales_without_a_room_are_refused(tmp_path: Path, scale: float) -> None:
    Image.fromarray(room_picture()).save(tmp_path / "room.png")
    with pytest.raises(TaskError, match="metres a pixel must be from|m wide is larger"):
        read_image(tmp_path / "room.png", scale)


def png_of_size(width: int, height: int) -> bytes:
    """A short file that claims to be large."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")


@pytest.mark.parametrize("size", [(5000, 5000), (2**31 - 1, 1), (2**31 - 1, 2**31 - 1), (20000, 20000)])
def test_huge_pictures_are_refused_unread(tmp_path: Path, size: tuple[int, int]) -> None:
    with pytest.raises(TaskError, match="are more than 16,000,000|not a picture that can be read"):
        read_image(write(tmp_path / "room.png", png_of_size(*size)), 0.05)


def test_truncated_pictures_are_refused(tmp_path: Path) -> None:
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (40, 60), dtype=np.uint8)).save(tmp_path / "whole.png")
    whole = (tmp_path / "whole.png").read_bytes()
    for length in range(0, len(whole) - 60, 97):
        with pytest.raises(TaskError, match="not a picture that can be read"):
            read_image(write(tmp_path / "room.png", whole[:length]), 0.1)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"no picture",
        b"P5 4000 4000 255\n1",
        b"P5 -3 9 255\n",
        b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n",
    ],
)
def test_files_without_a_picture_are_refused(tmp_path: Path, content: bytes) -> None:
    with pytest.raises(TaskError, match=r"room.png is not a picture that can be read: PNG, PPM"):
        read_image(write(tmp_path / "room.png", content), 0.1)


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.png")
    for name, message in (("none.png", "there is no file"), ("pipe.png", "is not a file"), (".", "is not a file")):
        with pytest.raises(TaskError, match=message):
            read_image(tmp_path / name, 0.1)


def test_files_of_many_bytes_are_refused(tmp_path: Path) -> None:
    with (tmp_path / "room.png").open("wb") as file:
        file.truncate(10**12)  # sparse
    with pytest.raises(TaskError, match="larger than 20 MB"):
        read_image(tmp_path / "room.png", 0.1)


def test_a_black_picture_has_no_floor(tmp_path: Path) -> None:
    Image.fromarray(np.zeros((9, 9), dtype=np.uint8)).save(tmp_path / "room.png")
    with pytest.raises(TaskError, match=r"room.png: it has no free floor"):
        read_image(tmp_path / "room.png", 0.1)
