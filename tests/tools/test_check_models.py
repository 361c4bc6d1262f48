from pathlib import Path

import pytest

from tasks.scene.loading import MODELS
from tools import check_models

SCENE = """<mujoco model="nav_a">
  <!-- A scene. -->
  <include file="room/a.xml"/>
</mujoco>
"""
ROOM = """<mujoco model="a">
  <worldbody>
    <geom name="floor" type="plane"
      size="0 0 1"/>
    <body name="ball">
      <freejoint name="ball"/>
      <geom name="ball" size="1"/>
    </body>
  </worldbody>
</mujoco>
"""
README = """# Room

![A room](a.png) `a.xml`

| element | size | source |
|---|---|---|
| ball | 1 m | assumed |

**Known differences.** None.
"""


@pytest.fixture
def models(tmp_path: Path) -> Path:
    (tmp_path / "room").mkdir()
    (tmp_path / "nav_a.xml").write_text(SCENE)
    (tmp_path / "room" / "a.xml").write_text(ROOM)
    (tmp_path / "room" / "README.md").write_text(README)
    (tmp_path / "room" / "a.png").touch()
    return tmp_path


def change(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_good_models_have_no_faults(models: Path) -> None:
    assert check_models.find_faults(models) == []


@pytest.mark.parametrize(
    ("name", "old", "new", "line", "sentence"),
    [
        ("a.xml", "</worldbody>", "</worldbodies>", 9, "this is not XML"),
        ("a.xml", "    <body", "   <body", 5, "stands in column 3; its depth requires 4"),
        ("a.xml", "    </body", "      </body", 8, "stands in column 6; its depth requires 4"),
        ("a.xml", 'size="1"', 'size="1"' + 100 * " " + 'mass="1"', 7, "columns; 120 are allowed"),
        ("a.xml", 'geom name="ball"', 'geom\tname="ball"', 7, "has a tab"),
        ("a.xml", "<worldbody>", "<worldbody> ", 2, "trailing blanks"),
        ("a.xml", "</mujoco>\n", "</mujoco>", 10, "must end in a newline"),
        ("a.xml", 'size="1"', 'size="-1"', 1, "MuJoCo does not compile the scene: "),
        ("a.xml", 'geom name="ball"', "geom", 1, "geom number 1 of the compiled scene has no name"),
        ("a.xml", '<freejoint name="ball"/>', "<freejoint/>", 1, "joint number 0 of the compiled scene has no name"),
        ("README.md", "a.png", "b.png", 3, "the picture b.png does not exist"),
        ("README.md", "![A room](a.png)", "", 1, "there is no picture"),
        ("README.md", "source", "origin", 1, "no table with a column `source`"),
        ("README.md", "Known differences", "Otherwise", 1, "'Known differences'"),
        ("README.md", "`a.xml`", "a room", 1, "`a.xml` is not named"),
    ],
)
def test_each_fault_is_found(models: Path, name: str, old: str, new: str, line: int, sentence: str) -> None:
    change(models / "room" / name, old, new)
    found = check_models.find_faults(models)
    assert found[0].line == line
    assert sentence in found[0].sentence
    assert len(found) == 1 or "not XML" in sentence  # which MuJoCo does not compile either


def test_a_folder_without_a_readme_is_a_fault(models: Path) -> None:
    (models / "room" / "README.md").unlink()
    (fault,) = check_models.find_faults(models)
    assert "needs a README.md" in str(fault)


def test_the_program_prints_faults_and_fails(
    models: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(check_models, "MODELS", models)
    monkeypatch.chdir(models)
    check_models.main([])
    assert capsys.readouterr().out == "2 model files are well formed\n"
    change(models / "nav_a.xml", "  <include", " <include")
    with pytest.raises(SystemExit, match="1"):
        check_models.main([])
    assert capsys.readouterr().out == "nav_a.xml:3: the tag stands in column 1; its depth requires 2\n"


def test_the_projects_own_rooms_are_in_form() -> None:
    found = [fault for fault in check_models.find_faults(MODELS) if fault.path.parent.name != "pioneer"]
    assert not found, "\n".join(map(str, found))
