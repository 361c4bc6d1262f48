"""Mazes drawn with characters."""

from pathlib import Path

import pytest

from tasks.errors import TaskError
from tasks.physics import Pose
from tasks.rooms.flat.text_maze import read_maze
from tests.support.room_clearances import room_clearances

MAZE = """\
########
#S.#..G#
#..#...#
#......#
########
"""


def write(folder: Path, content: str | bytes) -> Path:
    path = folder / "maze.txt"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def test_cells_are_walls_of_a_metre_and_the_last_line_lies_along_y_0(tmp_path: Path) -> None:
    room = read_maze(write(tmp_path, MAZE))
    # The wall in the midst: x from 3 to 4 m, y from 2 to 5 m.
    points = [(3.5, 3.0), (0.5, 2.5), (3.5, 1.75), (2.0, 2.0), (2.5, 3.0)]
    assert room_clearances(room, points) == pytest.approx([0, 0, 0.25, 1.0, 0.5])
    assert room.omitted == ()


def test_starts_and_goals_are_pairs(tmp_path: Path) -> None:
    assert read_maze(write(tmp_path, MAZE)).pairs == ((Pose(1.5, 3.5, 0.0), (6.5, 3.5)),)
    pairs = read_maze(write(tmp_path, "S.G\nG.S")).pairs
    assert len(pairs) == 4
    assert ((Pose(2.5, 0.5, 0.0), (2.5, 1.5))) in pairs


def test_a_first_line_gives_the_side_of_a_cell(tmp_path: Path) -> None:
    room = read_maze(write(tmp_path, "cell 0.5\n" + MAZE))
    assert room.pairs == ((Pose(0.75, 1.75, 0.0), (3.25, 1.75)),)
    assert room_clearances(room, [(1.75, 1.5), (1.0, 1.0)]) == pytest.approx([0, 0.5])


@pytest.mark.parametrize(
    "text",
    [
        MAZE.replace("#", "1").replace(".", "0"),
        MAZE.replace(".", " "),
        MAZE.replace("\n", "\r\n"),
        "\n" + MAZE + "\n  \n",
        "\ufeff" + MAZE,
        "cell 1\n" + MAZE,
        MAZE.rstrip("\n"),
    ],
)
def test_other_spellings_are_the_same_maze(tmp_path: Path, text: str) -> None:
    assert read_maze(write(tmp_path, text)) == read_maze(write(tmp_path, MAZE))


def test_short_lines_end_in_floor(tmp_path: Path) -> None:
    assert read_maze(write(tmp_path, "#...\n#\n####")) == read_maze(write(tmp_path, "#...\n#...\n####"))


def test_a_start_without_a_goal_is_named(tmp_path: Path) -> None:
    for text, name in ((MAZE.replace("G", "."), "S"), (MAZE.replace("S", "."), "G")):
        room = read_maze(write(tmp_path, text))
        assert room.pairs == ()
        assert room.omitted == (f"the cells {name}: a pair takes a start, S, and a goal, G",)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "holds no maze"),
        ("\n \n", "holds no maze"),
        ("cell 0.5\n", "holds no maze"),
        ("###\n#x#\n###", r"row 2 of the maze has 'x' in column 2; it is made of # or 1 \(wall\)"),
        ("#\t#", r"row 1 of the maze has '\\t' in column 2"),
        ("cell nan\n#.#", "side of a cell must be from"),
        ("cell -1\n#.#", "side of a cell must be from"),
        ("cell\n#.#", "side of a cell must be a number, not ''"),
        ("cell 1 2\n#.#", "side of a cell must be a number, not '1 2'"),
        ("cell 400\n#.#", "m wide is larger"),
        ("###\n###", "no free floor"),
        (b"\xff\xfe#\x00", "not a text in UTF-8"),
        (b"#\x00#", r"has '\\x00' in column 2"),
        ("." * 5000 + "\n." * 5000, "are more than 16,000,000"),
        ("cell 0.1\n" + ("SG" * 100 + "\n") * 100, "10000 starts and 10000 goals are more than 1000 pairs"),
        (b"#" * 20_000_001, "larger than 20 MB"),
    ],
)
def test_broken_files_end_in_a_sentence(tmp_path: Path, content: str | bytes, message: str) -> None:
    with pytest.raises(TaskError, match=message) as error:
        read_maze(write(tmp_path, content))
    assert str(error.value).startswith(str(tmp_path / "maze.txt"))
    assert len(str(error.value)) < len(str(tmp_path)) + 200
