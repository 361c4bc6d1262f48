"""The picture tool: its arguments and its pictures."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from asddpg.errors import UserError
from tasks.errors import TaskError
from tools import picture


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], "SCENE is missing: a task, a robot"),
        (["nav_empty", "size=12"], "size must be as in 1280x800"),
        (["nav_empty", "size=9000x10"], "at most 4096x4096 px"),
        (["nav_empty", "file=here.txt"], r"a path that ends in \.png or \.jpg"),
    ],
)
def test_invalid_arguments_are_one_sentence(arguments: list[str], expected: str) -> None:
    with pytest.raises(UserError, match=expected):
        picture.main(arguments)


def test_scenes_and_cameras_that_do_not_exist_list_those_that_do() -> None:
    with pytest.raises(
        UserError,
        match="scene must be nav_empty, .*pioneer, turtlebot3_burger, .*or a file .*not 'nav_foo'",
    ):
        picture.main(["nav_foo"])
    with pytest.raises(TaskError, match=r"there is no scene file none\.xml"):
        picture.main(["none.xml"])
    with pytest.raises(TaskError, match="no camera 'front'; there are .*portrait.*free"):
        picture.main(["pioneer", "camera=front", "size=64x48"])


def test_draws_the_robot_with_its_shadow(tmp_path: Path) -> None:
    drawn = {}
    for shadows in ("true", "false"):
        path = tmp_path / f"{shadows}.png"
        picture.main(["pioneer", f"file={path}", "size=160x100", f"shadows={shadows}"])
        drawn[shadows] = np.asarray(Image.open(path)).astype(int)
    red = (drawn["true"][..., 0] > 2 * drawn["true"][..., 1] + 20).mean()
    assert drawn["true"].shape == (100, 160, 3)
    assert 0.03 < red < 0.5
    assert (drawn["false"].sum(axis=2) - drawn["true"].sum(axis=2) > 60).mean() > 0.01


def test_a_file_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be written"):
        picture.main(["nav_empty", f"file={tmp_path}/none/a.png", "size=64x48"])
