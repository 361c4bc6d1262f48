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
    ("old", "new", "line", "sentence"),
    [
        ("</worldbody>", "</worldbodies>", 9, "this is not XML"),
        ("    <body", "   <body", 5, "stands in column 3; its depth requires 4"),
        ("    </body", "      </body", 8, "stands in column 6; its depth requires 4"),
        ('size="1"', 'size="1"' + 100 * " " + 'mass="1"', 7, "columns; 120 are allowed"),
        ('geom name="ball"', 'geom\tname="ball"', 7, "has a tab"),
        ("<worldbody>", "<worldbody> ", 2, "trailing blanks"),
        ("</mujoco>\n", "</mujoco>", 10, "must end in a newline"),
    ],
)
def test_each_fault_of_the_text_is_found(models: Path, old: str, new: str, line: int, sentence: str) -> None:
    path = models / "room" / "a.xml"
    change(path, old, new)
    found = check_models.xml_faults(path)
    assert [(fault.path, fault.line) for fault in found] == [(path, line)]
    assert sentence in found[0].sentence


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('size="1"', 'size="-1"', "MuJoCo does not compile the scene: "),
        ('geom name="ball"', "geom", "geom number 1 of the compiled scene has no name"),
        ('<freejoint name="ball"/>', "<freejoint/>", "joint number 0 of the compiled scene has no name"),
    ],
)
def test_each_fault_of_a_scene_is_found(models: Path, old: str, new: str, sentence: str) -> None:
    change(models / "room" / "a.xml", old, new)
    (fault,) = check_models.scene_faults(models / "nav_a.xml")
    assert sentence in fault.sentence


@pytest.mark.parametrize(
    ("old", "new", "line", "sentence"),
    [
        ("a.png", "b.png", 3, "the picture b.png does not exist"),
        ("![A room](a.png)", "", 1, "there is no picture"),
        ("source", "origin", 1, "no table with a column `source`"),
        ("Known differences", "Otherwise", 1, "'Known differences'"),
        ("`a.xml`", "a room", 1, "`a.xml` is not named"),
    ],
)
def test_each_fault_of_a_readme_is_found(models: Path, old: str, new: str, line: int, sentence: str) -> None:
    change(models / "room" / "README.md", old, new)
    (fault,) = check_models.folder_faults(models / "room")
    assert fault.line == line
    assert sentence in fault.sentence


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
    assert capsys.readouterr().out == "nav_a.xml:3: the tag stands in column 1; its depth wants 2\n"


def test_the_projects_own_rooms_are_in_form() -> None:
    found = [fault for fault in check_models.find_faults(MODELS) if fault.path.parent.name != "pioneer"]
    assert not found, "\n".join(map(str, found))
