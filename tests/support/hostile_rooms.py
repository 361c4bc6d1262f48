"""Broken and hostile files of rooms."""

import io
import os
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
from PIL import Image

from tests.support.room_files import FORMATS, write_ros_map

SUFFIXES = (".xml", ".world", ".sdf", ".yaml", ".yml", ".txt", ".png", ".pgm", ".jpg", ".bmp")
SCALE = "@0.05"  # of pictures
STILL_ROOMS = ("cut_", "changed_", "number_", "aliases", "includes")  # some files of these names are rooms all the same

NUMBERS = ("nan", "inf", "-inf", "-1", "1e300", "1e-300", "1e9", "0x10", "abc", "", "1;2", "½")
MJCF = "<mujoco><worldbody>{}</worldbody></mujoco>"
SDF = "<sdf version='1.6'><world name='w'><model name='m'><link name='l'>{}</link></model></world></sdf>"
SHAPE = SDF.format("<collision name='c'><geometry>{}</geometry></collision>")
ORIGIN = "origin: [0, 0, 0]\n"

# Suffix and text of a file with @ in the place of a number.
FIELDS = (
    (".xml", MJCF.format("<geom type='box' size='@ 1 1'/>")),
    (".xml", MJCF.format("<geom type='box' size='1 1 1' pos='0 @ 0'/>")),
    (".xml", MJCF.format("<geom type='box' size='1 1 1' quat='@ 0 0 1'/>")),
    (".xml", MJCF.format("<body><freejoint/><geom type='box' size='.1 .1 .1' mass='@'/></body>")),
    (".xml", MJCF.format("<replicate count='@'><geom type='sphere' size='1'/></replicate>")),
    (".world", SHAPE.format("<box><size>@ 1 1</size></box>")),
    (".world", SHAPE.format("<cylinder><radius>@</radius><length>1</length></cylinder>")),
    (
        ".sdf",
        SHAPE.format("<sphere><radius>1</radius></sphere>").replace("<geometry>", "<pose>@ 0 0 0 0 0</pose><geometry>"),
    ),
    (".yaml", f"image: map.pgm\nresolution: @\n{ORIGIN}"),
    (".yaml", "image: map.pgm\nresolution: 0.05\norigin: [@, 0, 0]\n"),
    (".yaml", f"image: map.pgm\nresolution: 0.05\n{ORIGIN}occupied_thresh: @\n"),
    (".yml", "world: {width: @, height: 9}\nobstacle: []\n"),
    (".yml", "obstacle:\n  - {shape: {name: circle, radius: @}, state: [1, 1, 0]}\n"),
    (".yml", "obstacle:\n  - {shape: {name: circle, radius: 1}, state: [@, 1, 0]}\n"),
    (".txt", "cell @\n####\n#  #\n####\n"),
)
BOMBS = {
    "entities.xml": '<!DOCTYPE a [<!ENTITY a "ha"><!ENTITY b "' + "&a;" * 100 + '">]><mujoco model="&b;"/>',
    "entities.world": '<!DOCTYPE a [<!ENTITY a "ha"><!ENTITY b "' + "&a;" * 100 + '">]><sdf version="1.6">&b;</sdf>',
    "external.xml": '<!DOCTYPE a [<!ENTITY a SYSTEM "/etc/passwd">]><mujoco>&a;</mujoco>',
    "deep.xml": "<mujoco><worldbody>" + "<body>" * 50_000,
    "deep.world": "<sdf version='1.6'>" + "<world>" * 50_000,
    "deep.yaml": "[" * 50_000,
    "deeper.yml": "a: " + "{a: " * 20_000,
    "aliases.yaml": "a: &a [x, x]\n"
    + "".join(f"{c}: &{c} [*{b}, *{b}]\n" for b, c in zip("abcdef", "bcdefg", strict=True)),
    "outside.yaml": "image: ../../../etc/passwd\nresolution: 0.05\norigin: [0, 0, 0]\n",
    "absolute.yaml": "image: /etc/passwd\nresolution: 0.05\norigin: [0, 0, 0]\n",
    "itself.yaml": "image: itself.yaml\nresolution: 0.05\norigin: [0, 0, 0]\n",
    "device.yaml": "image: /dev/zero\nresolution: 0.05\norigin: [0, 0, 0]\n",
    "python.yaml": "!!python/object/apply:os.system ['touch ran']\n",
    "pythonic.yml": "world: !!python/object/apply:os.system ['touch ran']\n",
    "include.xml": "<mujoco><include file='include.xml'/></mujoco>",
    "include_outside.xml": "<mujoco><include file='../../etc/passwd'/></mujoco>",
    "mesh_outside.xml": "<mujoco><asset><mesh file='/etc/passwd'/></asset></mujoco>",
    "mesh_device.xml": "<mujoco><asset><mesh name='m' file='/dev/zero'/></asset></mujoco>",
    "million.xml": MJCF.format("<replicate count='1000000'><geom type='sphere' size='1'/></replicate>"),
    "nested.xml": MJCF.format("<replicate count='999'>" * 5 + "<geom type='sphere' size='1'/>" + "</replicate>" * 5),
    "many.yaml": "obstacle:\n  - {number: 1000000, shape: {name: circle}}\n",
    "wide.txt": "#" * 5_000_000 + "\n" + "# " * 100,
    "tall.txt": "#\n" * 5_000_000,
    "pairs.txt": "S" * 2000 + "\n" + "G" * 2000,
    "solid.txt": "####\n####",
    "large.txt": "cell 500\n###\n# #\n###\n",
    "page.world": "<html><body>Not found</body></html>",
    "list.yaml": "- 1\n- 2\n",
    "neither.yml": "a: 1\n",
    "includes.world": "<sdf version='1.6'><world name='w'><include><uri>file:///etc/passwd</uri></include></world></sdf>",
}


def write_hostile(folder: Path) -> Iterator[str]:
    """Write files and yield their names as rooms, more than 300 of them."""
    yield from _damaged(folder)
    write_ros_map(folder)
    for number, ((suffix, text), value) in enumerate(product(FIELDS, NUMBERS)):
        yield _write(folder, f"number_{number}{suffix}", text.replace("@", value).encode())
    for name, text in BOMBS.items():
        yield _write(folder, name, text.encode())
    rng = np.random.default_rng(1)
    for suffix in SUFFIXES:
        for name, content in {
            "empty": b"",
            "rubbish": rng.bytes(3000),
            "zeros": bytes(3000),
            "utf16": "<mujoco/>\n####".encode("utf-16"),
        }.items():
            yield _write(folder, f"{name}{suffix}", content)
    for side in (4001, 6000):
        buffer = io.BytesIO()
        Image.new("1", (side, side), 1).save(buffer, "PNG")
        yield _write(folder, f"large_{side}.png", buffer.getvalue())
    yield _write(folder, "huge.pgm", b"P5 100000 100000 255\n")
    yield _write(folder, "huge.xml", b" " * 21_000_000)
    os.mkfifo(folder / "pipe.world")
    (folder / "folder.yaml").mkdir()
    (folder / "circle.txt").symlink_to(folder / "circle.txt")
    (folder / "zero.xml").symlink_to("/dev/zero")
    yield from (str(folder / name) for name in ("pipe.world", "folder.yaml", "circle.txt", "zero.xml"))


def _damaged(folder: Path) -> Iterator[str]:
    """Rooms cut short, and with bytes that were changed: some are rooms still."""
    rng = np.random.default_rng(0)
    for form in [form for form in FORMATS if form != "generated"]:
        home = folder / form.replace(" ", "_")
        home.mkdir()
        path = str(home / FORMATS[form](home)).removesuffix(SCALE)
        content = Path(path).read_bytes()
        for number in range(6):
            cut = content[: int(rng.integers(len(content)))]
            yield _write(home, f"cut_{number}{Path(path).suffix}", cut)
            changed = bytearray(content)
            for place in rng.integers(len(content), size=4):
                changed[place] = int(rng.integers(256))
            yield _write(home, f"changed_{number}{Path(path).suffix}", bytes(changed))


def _write(folder: Path, name: str, content: bytes) -> str:
    path = folder / name
    path.write_bytes(content)
    return f"{path}{SCALE if path.suffix in SUFFIXES[6:] else ''}"
