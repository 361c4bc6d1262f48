"""A bad scene file gives one sentence that names the file, the element and the valid value."""

import re
from pathlib import Path

import pytest

from tasks import registry
from tasks.errors import TaskError
from tasks.physics import Physics
from tasks.registry import ROOM_TASKS
from tasks.scene.checks import find_missing_elements
from tasks.scene.loading import MODELS, TASK_CAMERAS, model_hash, open_scene, scene_path

BEAMS = '<rangefinder name="range_00" site="ray"/>'
WHOLE = """<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 0.1"/>
    <body name="goal" mocap="true"/>
    <body name="base"><freejoint name="base"/><geom name="hull" size="0.1"/><site name="ray"/>
      <body name="left"><joint name="left_wheel"/><geom name="left_wheel" size="0.1"/></body>
      <body name="right"><joint name="right_wheel"/><geom name="right_wheel" size="0.1"/></body>
    </body>
  </worldbody>
  <actuator><motor name="left_wheel" joint="left_wheel"/><motor name="right_wheel" joint="right_wheel"/></actuator>
  <sensor><rangefinder name="range_00" site="ray"/></sensor>
</mujoco>"""


def sentence(path: Path, xml: str | None = None) -> str:
    """The error that opening a scene raises."""
    if xml is not None:
        path.write_text(xml)
    with pytest.raises(TaskError) as caught:
        open_scene(path)
    message = str(caught.value)
    assert str(path) in message
    assert "\n" not in message
    return message.replace(str(path), "FILE")


def test_the_least_scene_with_a_robot_opens(tmp_path: Path) -> None:
    path = tmp_path / "least.xml"
    path.write_text(WHOLE)
    assert open_scene(path).num_beams == 1
    with pytest.raises(TaskError, match=r"lacks the camera 'chase', the camera 'top'"):
        open_scene(path, TASK_CAMERAS)


def test_the_scenes_of_the_tasks_open_and_compile_to_one_model_each() -> None:
    hashes = []
    for name in ROOM_TASKS:
        physics = open_scene(scene_path(name), TASK_CAMERAS)
        assert find_missing_elements(physics.model.ptr, TASK_CAMERAS) == []
        hashes.append(model_hash(physics.model.ptr))
        assert hashes[-1] == model_hash(Physics.from_xml_path(str(scene_path(name))).model.ptr)
    assert len(set(hashes)) == len(hashes)


@pytest.mark.parametrize("name", ["none.xml", ""])
def test_no_such_file(tmp_path: Path, name: str) -> None:
    assert sentence(tmp_path / name) == "there is no scene file FILE; an MJCF file, .xml, is expected"


@pytest.mark.parametrize(
    ("xml", "expected"),
    [
        ("", "FILE cannot be compiled: .*empty file"),
        ("<mujoco>\n<worldbdy>", "FILE cannot be compiled: .*Line number=2.*worldbdy"),
        ("<mujoco>\n<geoom/></mujoco>", "unrecognized element, Element 'geoom', line 2"),
        ("<mujoco><worldbody>\n<geom name='a' type='box'/></worldbody></mujoco>", "geom, Element name 'a', .*line 2"),
        ("<mujoco>\n<include file='nix.xml'/></mujoco>", "opening file 'nix.xml', Element 'include', line 2"),
        ("<mujoco><include file='room.xml'/></mujoco>", "Element 'joom', in a file it includes"),
    ],
)
def test_mujocos_error_keeps_line_and_element(tmp_path: Path, xml: str, expected: str) -> None:
    (tmp_path / "room.xml").write_text("<mujoco>\n<worldbody>\n<joom/>\n</worldbody></mujoco>")
    assert re.search(expected, sentence(tmp_path / "bad.xml", xml))


@pytest.mark.parametrize("timestep", ["0", "-0.01", "nan", "5"])
def test_a_timestep_out_of_range(tmp_path: Path, timestep: str) -> None:
    xml = WHOLE.replace("<mujoco>", f'<mujoco><option timestep="{timestep}"/>')
    required = "it must be above 0 s and at most 0.02 s"
    expected = f"the scene FILE has the timestep {float(timestep):g} in its option element, but {required}"
    assert sentence(tmp_path / "bad.xml", xml) == expected


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('name="hull"', 'name="hull" pos="nan 0 0"', "the geom 'hull' with pos nan 0 0, but it must be finite"),
        ('name="hull" size="0.1"', 'name="hull" type="box" mass="1" size="1 1 inf"', "size 1 1 inf"),
        ('name="goal"', 'name="goal" pos="0 inf 0"', "the body 'goal' with pos 0 inf 0"),
        ("<worldbody>", '<worldbody><camera pos="nan 0 0"/>', "the camera number 0 with pos nan 0 0, but"),
    ],
)
def test_numbers_that_are_not_finite(tmp_path: Path, old: str, new: str, expected: str) -> None:
    assert expected in sentence(tmp_path / "bad.xml", WHOLE.replace(old, new, 1))


@pytest.mark.parametrize(
    ("old", "new", "missing"),
    [
        ('<body name="base">', '<body name="hull">', "body 'base'"),
        ('<freejoint name="base"/>', "", "free joint 'base' of the body 'base'"),
        ('<freejoint name="base"/>', '<joint name="base"/>', "free joint 'base' of the body 'base'"),
        (' mocap="true"', "", "mocap body 'goal'"),
        ('<motor name="left_wheel"', '<motor name="l"', "actuator 'left_wheel'"),
        ('<motor name="right_wheel"', '<motor name="r"', "actuator 'right_wheel'"),
        (BEAMS, "", "rangefinder sensors range_00, range_01, …"),
        (BEAMS, '<gyro name="range_00" site="ray"/>', "rangefinder sensors range_00, range_01, …"),
        ('<geom name="floor"', '<geom name="ground"', "geom 'floor'"),
    ],
)
def test_an_element_that_is_missing(tmp_path: Path, old: str, new: str, missing: str) -> None:
    message = sentence(tmp_path / "bad.xml", WHOLE.replace(old, new))
    assert message.startswith("the scene FILE lacks the ")
    assert f"the {missing}" in message
    assert "pioneer/pioneer.xml brings the robot" in message


def test_errors_of_physics_name_the_file(tmp_path: Path) -> None:
    between = f'{BEAMS}<gyro name="gyro" site="ray"/>{BEAMS.replace("00", "01")}'
    assert "follow one another" in sentence(tmp_path / "bad.xml", WHOLE.replace(BEAMS, between))


@pytest.mark.parametrize("name", ["nav_empty", "nav_gazebo"])
def test_a_room_that_leaves_no_free_space_is_named(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    full = tmp_path / "full.xml"
    full.write_text(
        f'<mujoco><include file="{MODELS}/rooms/common.xml"/><include file="{MODELS}/pioneer/pioneer.xml"/><worldbody>'
        '<camera name="top"/><geom name="block" type="box" size="4 4 1"/></worldbody></mujoco>'
    )
    monkeypatch.setattr(registry, "scene_path", lambda _: full)
    with pytest.raises(TaskError, match=f"the scene {full} gives no starts and goals: .*free place"):
        registry.load(name)
