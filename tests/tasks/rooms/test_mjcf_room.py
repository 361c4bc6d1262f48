import os
import resource
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tasks.errors import TaskError
from tasks.room_geometry.obstacles import Obstacles
from tasks.rooms.room import Room, Shape
from tasks.rooms.scene import compile_room
from tasks.rooms.solid.mjcf_room import read_mjcf
from tasks.scene.loading import MODELS, load_model, scene_path

WALLS = "".join(
    f'<geom type="box" pos="{x} {y} 0.25" size="{half} 0.25"/>'
    for x, y, half in [(3.05, 0, "0.05 3.1"), (-3.05, 0, "0.05 3.1"), (0, 3.05, "3 0.05"), (0, -3.05, "3 0.05")]
)
TETRAHEDRON = "0 0 0  1 0 0  0 1 0  0 0 1"
TRIANGLES = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def read(folder: Path, things: str, before: str = "") -> Room:
    path = folder / "room.xml"
    path.write_text(f"<mujoco>{before}<worldbody>{things}</worldbody></mujoco>")
    return read_mjcf(path)


def test_nested_bodies_frames_and_defaults_give_positions_in_the_world(tmp_path: Path) -> None:
    thing = '<geom name="g" class="leg" pos="1 0 0"/>'
    body = f'<body pos="2 1 0" euler="0 0 90"><frame euler="0 0 90" pos="0.5 0 0.3">{thing}</frame></body>'
    (leg,) = read(
        tmp_path, body, '<default><default class="leg"><geom type="box" size=".1 .2 .3"/></default></default>'
    ).obstacles
    # The body's x axis is the world's y, the frame's the world's -x: (2, 1) + (0, 0.5) + (-1, 0).
    assert leg.position == pytest.approx((1, 1.5, 0.3))
    assert np.abs(leg.quaternion) == pytest.approx((0, 0, 0, 1), abs=1e-9)
    assert (leg.shape, leg.size, leg.name) == (Shape.BOX, (0.1, 0.2, 0.3), "g")


def test_every_shape_becomes_what_it_is(tmp_path: Path) -> None:
    things = """<geom type="cylinder" size="0.2 0.3" pos="0 0 0.3"/><geom size="0.2" pos="1 0 0.3"/>
        <geom type="capsule" size="0.2 0.3" pos="2 0 0.5"/><geom type="ellipsoid" size="0.3 0.2 0.5" pos="3 0 0.5"/>
        <geom type="mesh" mesh="m" pos="4 0 0"/><geom type="capsule" fromto="5 0 0.2 5 1 0.2" size="0.1"/>"""
    room = read(tmp_path, things, f'<asset><mesh name="m" vertex="{TETRAHEDRON}"/></asset>')
    cylinder, sphere, capsule, ellipsoid, mesh, lying = room.obstacles
    assert (cylinder.shape, cylinder.size) == (Shape.CYLINDER, (0.2, 0.3))
    assert (sphere.shape, sphere.size) == (Shape.SPHERE, (0.2,))
    assert np.ptp(capsule.points, axis=0) == pytest.approx((0.4, 0.4, 1.0), rel=0.03)
    assert np.ptp(ellipsoid.points, axis=0) == pytest.approx((0.6, 0.4, 1.0), rel=0.03)
    assert len(mesh.points) == 4
    assert lying.position == pytest.approx((5, 0.5, 0.2))
    assert not room.omitted
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, np.array(mesh.quaternion))
    corners = np.array(mesh.points) @ turn.reshape(3, 3).T + mesh.position
    assert np.array(sorted(corners.round(5).tolist())) == pytest.approx(
        np.array([(4, 0, 0), (4, 0, 1), (4, 1, 0), (5, 0, 0)]), abs=1e-5
    )


def test_what_is_not_taken_is_named(tmp_path: Path) -> None:
    things = """<geom name="floor" type="plane" size="0 0 1"/>
        <geom name="mirror" type="plane" size="1 1 1" zaxis="1 0 0"/>
        <geom name="hill" type="hfield" hfield="h"/><geom name="poster" size="0.1" contype="0" conaffinity="0"/>
        <body name="door"><joint/><geom size="0.1" pos="0 0 1"/></body>
        <body name="table"><freejoint/><geom size="0.1" pos="0 0 1"/><geom size="0.1" pos="0 1 1"/></body>
        <body name="lift" mocap="true"><geom size="0.1" pos="0 0 1"/></body>
        <composite prefix="rope" type="cable" curve="s" count="9 1 1" size="1"><geom size="0.1"/></composite>"""
    room = read(tmp_path, things, '<asset><hfield name="h" nrow="2" ncol="2" size="1 1 1 1"/></asset>')
    assert len(room.obstacles) == 4
    assert not any(thing.mass for thing in room.obstacles)
    assert set(room.omitted) == {
        "'mirror': a plane that is not a floor is not read",
        "'hill': the shape hfield is not read",
        "'poster': without contacts, so visual only",
        "the mobility of 'door', the mobility of 'lift': it has joints, or moves by a programme, so it stands fixed",
        "the mobility of 'table': it consists of several solids, so it stands fixed",
        "composite 'rope': <composite> is not read",
    }


def test_a_body_with_a_free_joint_falls_and_can_be_pushed(tmp_path: Path) -> None:
    carton = '<body name="carton" pos="1 0 1"><freejoint/><geom type="box" size="0.2 0.2 0.2" mass="2"/></body>'
    compiled = compile_room(read(tmp_path, WALLS + carton))
    assert compiled.body("carton").mass == pytest.approx(2)
    data = mujoco.MjData(compiled)
    mujoco.mj_step(compiled, data, 400)
    assert data.body("carton").xpos == pytest.approx((1, 0, 0.2), abs=0.01)
    data.body("carton").xfrc_applied[0] = 20.0
    mujoco.mj_step(compiled, data, 100)
    assert data.body("carton").xpos[0] > 1.2


@pytest.mark.parametrize("task", ["nav_complex", "nav_gazebo", "nav_office"])
def test_the_projects_own_scene_without_its_robot_is_the_same_room(task: str) -> None:
    room = read_mjcf(scene_path(task))
    outlines, original = (
        Obstacles.from_model(model).outlines for model in (compile_room(room), load_model(scene_path(task)))
    )
    assert len(outlines) == len(original)
    pairs = zip(sorted(map(sorted, outlines)), sorted(map(sorted, original)), strict=True)
    assert all(np.allclose(ours, theirs, atol=1e-6) for ours, theirs in pairs)
    assert all("visual only" in sentence for sentence in room.omitted)


def test_includes_and_meshes_lie_beside_the_file_or_below(tmp_path: Path) -> None:
    (tmp_path / "parts" / "meshes").mkdir(parents=True)
    (tmp_path / "parts" / "meshes" / "m.obj").write_text(TRIANGLES)
    inside = '<compiler meshdir="parts/meshes"/><asset><mesh file="m.obj"/></asset>'
    inside += '<worldbody><geom type="mesh" mesh="m"/><include file="deep.xml"/></worldbody>'
    (tmp_path / "parts" / "a.xml").write_text(f"<mujoco>{inside}</mujoco>")
    (tmp_path / "parts" / "deep.xml").write_text('<mujocoinclude><geom size="0.2"/></mujocoinclude>')
    (tmp_path / "room.xml").write_text('<mujoco><include file="parts/a.xml"/></mujoco>')
    assert [thing.shape for thing in read_mjcf(tmp_path / "room.xml").obstacles] == [Shape.HULL, Shape.SPHERE]


def test_a_texture_that_is_missing_is_not_missed(tmp_path: Path) -> None:
    before = '<asset><texture name="t" type="2d" file="none.png"/><material name="m" texture="t"/></asset>'
    assert len(read(tmp_path, '<geom size="1" material="m"/>', before).obstacles) == 1


# Hostile files --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "inside",
    [
        '<include file="../outside.xml"/>',
        '<include file="/etc/hostname"/>',
        '<include file="none.xml"/>',
        '<include file="room.xml"/>',
        '<include file="circle.xml"/>',
        '<include file="link.xml"/>',
        '<asset><mesh file="../outside.obj"/></asset>',
        '<asset><mesh file="none.obj"/></asset>',
        '<asset><mesh name="m" builtin="sphere" params="9999999"/></asset>',
        '<asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>',
        '<worldbody><geom size="nan"/></worldbody>',
        '<worldbody><geom size="-1"/></worldbody>',
        '<worldbody><geom size="1e300"/></worldbody>',
        '<worldbody><geom size="1" pos="inf 0 0"/></worldbody>',
        '<worldbody><geom size="x"/></worldbody>',
        '<worldbody><geom size="1" class="none"/></worldbody>',
        "<worldbody><body><freejoint/></body></worldbody>",
        '<worldbody><geom type="mesh" mesh="none"/></worldbody>',
        '<worldbody><replicate count="1000000000"><geom size="1"/></replicate></worldbody>',
        '<worldbody><replicate count="1000"><replicate count="1000"><body/></replicate></replicate></worldbody>',
        '<worldbody><replicate count="nan"><geom size="1"/></replicate></worldbody>',
        "<worldbody>" + '<geom size="1"/>' * 20_001 + "</worldbody>",
        "<worldbody>" + "<body>" * 200 + "</body>" * 200 + "</worldbody>",
    ],
)
def test_a_hostile_file_ends_in_one_sentence(tmp_path: Path, inside: str, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "inside"
    folder.mkdir()
    monkeypatch.chdir(folder)
    (tmp_path / "outside.xml").write_text("<mujoco/>")
    (tmp_path / "outside.obj").write_text(TRIANGLES)
    (folder / "link.xml").symlink_to(tmp_path / "outside.xml")
    (folder / "circle.xml").write_text('<mujoco><include file="circle.xml"/></mujoco>')
    (folder / "room.xml").write_text(f"<mujoco>{inside}</mujoco>")
    check(folder / "room.xml")
    assert sorted(os.listdir(folder)) == ["circle.xml", "link.xml", "room.xml"]


@pytest.mark.parametrize(
    "text",
    [
        "<!DOCTYPE m [<!ENTITY a 'b'>]><mujoco/>",
        "<mujoco><worldbody>",
        "",
        "\x00\x01",
        "<robot name='urdf'/>",
        "<mujoco>" + "<a/>" * 600_000 + "</mujoco>",
        "<mujoco>" + " " * 20_000_000 + "</mujoco>",
    ],
)
def test_what_is_no_mjcf_ends_in_one_sentence(tmp_path: Path, text: str) -> None:
    (tmp_path / "room.xml").write_text(text)
    check(tmp_path / "room.xml")


def check(path: Path) -> None:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(TaskError, match=r"room\.xml") as error:
        read_mjcf(path)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 250_000  # kB
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 600


def test_no_file_ends_in_one_sentence() -> None:
    with pytest.raises(TaskError, match="there is no file"):
        read_mjcf(MODELS / "none.xml")
