import resource
import struct
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tasks.errors import TaskError
from tasks.physics import FloatArray
from tasks.room_geometry.obstacles import Obstacles
from tasks.rooms.room import Room, Shape
from tasks.rooms.scene import compile_room
from tasks.rooms.solid.sdf_world import read_world

BOX = "<geometry><box><size>1 0.4 0.6</size></box></geometry>"
GROUND = (
    "<model name='ground'><link name='l'><collision name='c'><geometry><plane/></geometry></collision></link></model>"
)


def collision(geometry: str = BOX, pose: str = "", name: str = "c") -> str:
    return f"<collision name='{name}'>{pose and f'<pose>{pose}</pose>'}{geometry}</collision>"


def model(links: str, pose: str = "", name: str = "thing", static: bool = True) -> str:
    inside = links if links.startswith("<link") else f"<link name='link'>{links}</link>"
    return f"<model name='{name}'><static>{int(static)}</static>{pose and f'<pose>{pose}</pose>'}{inside}</model>"


def write(folder: Path, things: str, version: str = "1.6", name: str = "room.world") -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"<?xml version='1.0'?><sdf version='{version}'><world name='w'>{things}</world></sdf>")
    return path


def read(folder: Path, things: str, version: str = "1.6") -> Room:
    return read_world(write(folder, things, version))


def write_model(folder: Path, inside: str, name: str = "tree") -> None:
    (folder / name).mkdir(parents=True)
    (folder / name / "model.sdf").write_text(f"<sdf version='1.6'><model name='{name}'>{inside}</model></sdf>")


def box_mesh(half: tuple[float, float, float], centre: tuple[float, float, float] = (0, 0, 0)) -> FloatArray:
    """Twelve triangles (12, 3, 3) of a box."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = signs * half + centre
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [(a, b, c) for a, b, c, _ in quads] + [(a, c, d) for a, _, c, d in quads]
    return np.asarray(corners[np.array(triangles)])


def stl(triangles: FloatArray) -> bytes:
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *each.ravel(), 0) for each in triangles)
    return bytes(80) + struct.pack("<I", len(triangles)) + body


def obj(triangles: FloatArray) -> str:
    lines = [f"v {x} {y} {z}" for x, y, z in triangles.reshape(-1, 3)]
    lines += [f"f {i}/1 {i + 1}/1 {i + 2}/1" for i in range(1, 3 * len(triangles), 3)]
    return "\n".join(lines)


def mesh(uri: str, scale: str = "1 1 1") -> str:
    return collision(f"<geometry><mesh><uri>{uri}</uri><scale>{scale}</scale></mesh></geometry>")


WALLS = "".join(
    model(collision(f"<geometry><box><size>{size}</size></box></geometry>"), f"{x} {y} 0.25 0 0 0", f"wall_{i}")
    for i, (x, y, size) in enumerate(
        [(3.05, 0, "0.1 6.2 0.5"), (-3.05, 0, "0.1 6.2 0.5"), (0, 3.05, "6 0.1 0.5"), (0, -3.05, "6 0.1 0.5")]
    )
)


# Poses ----------------------------------------------------------------------------------------------------------------


def test_poses_of_model_link_and_collision_add_up(tmp_path: Path) -> None:
    inner = f"<link name='a'><pose>1 0 0 0 0 1.5707963267948966</pose>{collision(pose='0.5 0 0.3 0 0 0')}</link>"
    room = read(tmp_path, model(inner, "2 1 0 0 0 1.5707963267948966"))
    # The model's x axis is the world's y, the link's its -x: (2, 1) + (0, 1) + (-0.5, 0).
    (thing,) = room.obstacles
    assert thing.position == pytest.approx((1.5, 2.0, 0.3))
    assert np.abs(thing.quaternion) == pytest.approx((0, 0, 0, 1), abs=1e-9)
    assert thing.size == (0.5, 0.2, 0.3)
    assert not room.omitted


def test_roll_pitch_and_yaw_turn_about_fixed_axes(tmp_path: Path) -> None:
    (thing,) = read(tmp_path, model(collision(), "0 0 1 0.3 -0.5 1.1")).obstacles
    quarter = np.zeros(9)
    mujoco.mju_quat2Mat(quarter, np.array(thing.quaternion))
    roll, pitch, yaw = 0.3, -0.5, 1.1
    cos, sin = np.cos, np.sin
    first = (cos(yaw) * cos(pitch), sin(yaw) * cos(pitch), -sin(pitch))  # where the x axis goes
    assert quarter.reshape(3, 3)[:, 0] == pytest.approx(first)
    assert quarter.reshape(3, 3)[2, 1:] == pytest.approx((cos(pitch) * sin(roll), cos(pitch) * cos(roll)))


def test_a_turned_box_has_its_outline_in_the_scene(tmp_path: Path) -> None:
    compiled = compile_room(read(tmp_path, WALLS + model(collision(), "1 1 0.3 0 0 0.5", "turned")))
    cos, sin = np.cos(0.5), np.sin(0.5)
    corners = [(1 + cos * x - sin * y, 1 + sin * x + cos * y) for x in (-0.5, 0.5) for y in (-0.2, 0.2)]
    found = [outline for outline in Obstacles.from_model(compiled).outlines if np.allclose(np.mean(outline, axis=0), 1)]
    assert len(found) == 1
    assert np.array(sorted(found[0])) == pytest.approx(np.array(sorted(corners)), abs=1e-6)


def test_poses_may_be_relative_to_frames_and_links_of_the_model(tmp_path: Path) -> None:
    inside = (
        """<frame name='f' attached_to='a'><pose>0 1 0 0 0 0</pose></frame>
        <link name='a'><pose degrees='true'>1 0 0 0 0 90</pose></link>
        <link name='b'><pose relative_to='f'>0 0 0.3 0 0 0</pose>"""
        + collision()
        + "</link>"
    )
    (thing,) = read(tmp_path, f"<model name='m'><static>1</static>{inside}</model>", "1.9").obstacles
    assert thing.position == pytest.approx((0, 0, 0.3))  # a turns by 90 degrees, so its y is the model's -x


def test_a_quaternion_is_a_pose(tmp_path: Path) -> None:
    pose = "<pose rotation_format='quat_xyzw'>1 2 0.3 0 0 2 2</pose>"
    (thing,) = read(tmp_path, f"<model name='m'>{pose}<static>1</static><link>{collision()}</link></model>").obstacles
    assert thing.quaternion == pytest.approx((0.5**0.5, 0, 0, 0.5**0.5))


@pytest.mark.parametrize("target", ["elsewhere", "b", "link"])
def test_a_pose_relative_to_nothing_or_in_a_circle_is_named(tmp_path: Path, target: str) -> None:
    link = f"<link name='link'><pose relative_to='{target}'/>{collision()}</link>"
    room = read(tmp_path, model(link + "<frame name='b'><pose relative_to='link'/></frame>"))
    assert not room.obstacles
    assert room.omitted[0].startswith("'thing': its pose is relative to")


def test_models_in_models_and_models_at_a_frame_of_theirs_stand_where_they_should(tmp_path: Path) -> None:
    inner = "<model name='inner' placement_frame='foot'><pose>0 1 0 0 0 0</pose><link name='foot'>"
    inner += f"<pose>0 0 -0.3 0 0 0</pose></link><link name='top'>{collision()}</link></model>"
    outer = f"<model name='outer'><static>1</static><pose>3 0 0 0 0 1.5707963267948966</pose>{inner}</model>"
    (thing,) = read(tmp_path, outer, "1.8").obstacles
    assert thing.position == pytest.approx((2, 0, 0.3))
    assert thing.name == "outer_inner_top"


# Shapes ---------------------------------------------------------------------------------------------------------------


def test_every_shape_becomes_what_it_is(tmp_path: Path) -> None:
    shapes = {
        "sphere": "<radius>0.2</radius>",
        "cylinder": "<radius>0.2</radius><length>1</length>",
        "capsule": "<radius>0.2</radius><length>0.6</length>",
        "ellipsoid": "<radii>0.3 0.2 0.5</radii>",
        "polyline": "<point>0 0</point><point>0.5 0</point><point>0 0.5</point><height>0.7</height>",
    }
    things = [
        model(collision(f"<geometry><{kind}>{size}</{kind}></geometry>"), f"{i} 0 0.5 0 0 0", kind)
        for i, (kind, size) in enumerate(shapes.items())
    ]
    room = read(tmp_path, "".join(things))
    sphere, cylinder, capsule, ellipsoid, prism = room.obstacles
    assert (sphere.shape, sphere.size) == (Shape.SPHERE, (0.2,))
    assert (cylinder.shape, cylinder.size) == (Shape.CYLINDER, (0.2, 0.5))
    assert np.ptp(capsule.points, axis=0) == pytest.approx((0.4, 0.4, 1.0), rel=0.03)
    assert np.ptp(ellipsoid.points, axis=0) == pytest.approx((0.6, 0.4, 1.0), rel=0.03)
    assert np.array(prism.points).min(axis=0) + prism.position == pytest.approx((4, 0, 0.5))
    assert len(prism.points) == 6
    assert compile_room(room).nmesh == 3 + compile_room(Room(())).nmesh  # and those of the robot


def test_the_first_horizontal_plane_is_the_floor_and_ground_below_it_is_no_obstacle(tmp_path: Path) -> None:
    ground = model(collision("<geometry><plane><normal>0 0 1</normal></plane></geometry>"), "0 0 0.5 0 0 0", "ground")
    slab = model(collision("<geometry><box><size>500 500 0.2</size></box></geometry>"), "0 0 0.4 0 0 0", "slab")
    wall = model(collision("<geometry><plane><normal>1 0 0</normal></plane></geometry>"), name="wall")
    room = read(tmp_path, ground + slab + model(collision(), "0 0 0.8 0 0 0") + wall)
    (thing,) = room.obstacles
    assert thing.position == pytest.approx((0, 0, 0.3))
    assert room.omitted == ("'wall': a plane that is not a floor is not read",)


def test_what_is_solid_and_not_read_is_named_and_the_rest_is_not(tmp_path: Path) -> None:
    field = "<geometry><heightmap><uri>file://x.png</uri></heightmap></geometry>"
    visual = "<visual name='v'><geometry><mesh><uri>none.dae</uri></mesh></geometry></visual>"
    contact = "<surface><contact><collide_bitmask>0</collide_bitmask></contact></surface>"
    zone = f"<collision name='zone'>{BOX}{contact}</collision>"
    lights = "<light name='sun'/><plugin name='p' filename='p.so'/><state><model name='x'><link/></model></state>"
    far = model(collision(), "1000 0 0.3 0 0 0", "far")
    room = read(tmp_path, model(collision(field) + visual + zone, name="hill") + "<actor name='man'/>" + lights + far)
    assert not room.obstacles
    assert set(room.omitted) == {
        "actor 'man': actors are not read",
        "'hill': the geometry heightmap is not read",
        "'far': it reaches farther than 200 m from the origin",
    }


# Movable things -------------------------------------------------------------------------------------------------------


def test_a_thing_that_is_not_static_falls_and_can_be_pushed(tmp_path: Path) -> None:
    carton = "<inertial><mass>2</mass></inertial>" + collision(
        "<geometry><box><size>0.4 0.4 0.4</size></box></geometry>"
    )
    room = read(tmp_path, GROUND + WALLS + model(carton, "1 0 1 0 0 0", "carton", static=False))
    compiled = compile_room(room)
    assert compiled.body("carton").mass == pytest.approx(2)
    data = mujoco.MjData(compiled)
    mujoco.mj_step(compiled, data, 400)
    assert data.body("carton").xpos == pytest.approx((1, 0, 0.2), abs=0.01)
    data.body("carton").xfrc_applied[0] = 20.0
    mujoco.mj_step(compiled, data, 100)
    assert data.body("carton").xpos[0] > 1.2


@pytest.mark.parametrize(
    ("inside", "reason"),
    [
        (collision(name="a") + collision(name="b"), "it consists of several solids"),
        (f"<link name='link'>{collision()}</link><joint name='j'/>", "it has joints"),
        ("<kinematic>1</kinematic>" + collision(), "no gravity acts on it"),
    ],
)
def test_what_cannot_be_movable_stands_fixed_and_is_named(tmp_path: Path, inside: str, reason: str) -> None:
    room = read(tmp_path, model(inside, "0 0 0.3 0 0 0", static=False))
    assert room.obstacles
    assert not any(thing.mass for thing in room.obstacles)
    assert room.omitted == (f"the mobility of 'thing': {reason}, so it stands fixed",)


# Includes and meshes --------------------------------------------------------------------------------------------------


def test_an_included_model_has_the_name_pose_and_mobility_of_the_include(tmp_path: Path) -> None:
    write_model(tmp_path / "models", f"<pose>9 9 9 0 0 0</pose><link name='l'>{collision()}</link>")
    include = (
        "<include><uri>model://tree</uri><name>oak</name><pose>1 2 0.3 0 0 0</pose><static>true</static></include>"
    )
    path = write(tmp_path, include + "<include><uri>model://bush</uri></include>")
    (thing,) = (room := read_world(path, [tmp_path / "models"])).obstacles
    assert (thing.name, thing.position, thing.mass) == ("oak", (1, 2, 0.3), 0)
    assert len(room.omitted) == 1
    assert room.omitted[0].startswith("the model model://bush: it is not in ")


def test_the_config_of_a_model_chooses_its_newest_description(tmp_path: Path) -> None:
    write_model(tmp_path, "<link name='l'/>")
    new = f"<model name='t'><pose>0 0 0.3 0 0 0</pose><link name='l'>{collision()}</link></model>"
    (tmp_path / "tree" / "new.sdf").write_text(f"<sdf version='1.7'>{new}</sdf>")
    config = "<model><sdf version='1.5'>model.sdf</sdf><sdf version='1.7'>new.sdf</sdf></model>"
    (tmp_path / "tree" / "model.config").write_text(config)
    assert len(read(tmp_path, "<include><uri>model://tree</uri></include>").obstacles) == 1


def test_a_file_of_models_without_a_world_is_a_room(tmp_path: Path) -> None:
    write_model(tmp_path, f"<static>1</static><link name='l'>{collision()}</link>")
    assert len(read_world(tmp_path / "tree" / "model.sdf").obstacles) == 1


@pytest.mark.parametrize("suffix", ["stl", "txt.stl", "obj"])
def test_each_part_of_a_mesh_becomes_its_hull(tmp_path: Path, suffix: str) -> None:
    triangles = np.concatenate([box_mesh((50, 20, 30)), box_mesh((10, 10, 30), (100, 0, 0))])
    path = tmp_path / "tree" / "meshes" / f"two.{suffix}"
    write_model(tmp_path, f"<static>1</static><link name='l'>{mesh(f'meshes/two.{suffix}', '0.01 0.01 0.01')}</link>")
    path.parent.mkdir()
    if suffix == "obj":
        path.write_text(obj(triangles))
    elif suffix == "stl":
        path.write_bytes(stl(triangles))
    else:
        faces = [f"facet outer loop {' '.join(f'vertex {x} {y} {z}' for x, y, z in each)}" for each in triangles]
        path.write_text("solid two\n" + "\n".join(faces) + "\nendsolid two")
    room = read(tmp_path, "<include><uri>model://tree</uri><pose>1 1 0.3 0 0 0</pose></include>")
    places = np.array(sorted(thing.position for thing in room.obstacles))
    assert places == pytest.approx(np.array([(1, 1, 0.3), (2, 1, 0.3)]))
    sides = sorted(tuple(np.ptp(thing.points, axis=0)) for thing in room.obstacles)
    assert np.array(sides) == pytest.approx(np.array([(0.2, 0.2, 0.6), (1, 0.4, 0.6)]), rel=1e-6)
    assert not room.omitted
    assert compile_room(room).ngeom


def test_a_mesh_around_a_room_leaves_the_room_free(tmp_path: Path) -> None:
    outer, inner = box_mesh((3.1, 3.1, 0.5)), box_mesh((3, 3, 0.5))
    sides = [each for shell in (outer, inner) for each in shell if np.ptp(each[:, 2])]
    rims = []
    for z in (-0.5, 0.5):
        square = [np.array([(x * h, y * h, z) for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))]) for h in (3.1, 3.0)]
        for i in range(4):
            a, b, c, d = square[0][i - 1], square[0][i], square[1][i], square[1][i - 1]
            rims += [np.array([a, b, c]), np.array([a, c, d])]
    (tmp_path / "walls.stl").write_bytes(stl(np.array(sides + rims)))
    room = read(tmp_path, model(mesh("file://walls.stl"), "0 0 0.5 0 0 0", "walls"))
    assert room.omitted[0].startswith("the inside of 'walls': not all parts of the mesh file://walls.stl are convex")
    compiled = compile_room(room)
    assert np.abs(compiled.body("base").pos[:2]).max() < 0.2
    assert not any("fence" in compiled.geom(i).name for i in range(compiled.ngeom))


def test_a_collada_mesh_is_read_with_its_unit_and_the_matrices_of_its_nodes(tmp_path: Path) -> None:
    corners = box_mesh((50, 20, 30)).reshape(-1, 3)
    numbers, indices = " ".join(map(str, corners.ravel())), " ".join(f"{i} 0" for i in range(len(corners)))
    faces = "<input semantic='VERTEX' source='#v' offset='0'/><input semantic='NORMAL' source='#n' offset='1'/>"
    text = f"""<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>
      <asset><unit meter='0.01'/><up_axis>Y_UP</up_axis></asset>
      <library_geometries><geometry id='g'><mesh><source id='p'><float_array>{numbers}</float_array></source>
        <vertices id='v'><input semantic='POSITION' source='#p'/></vertices>
        <polylist>{faces}<vcount>{"3 " * 12}</vcount><p>{indices}</p></polylist></mesh></geometry></library_geometries>
      <library_visual_scenes><visual_scene><node><matrix>1 0 0 100 0 1 0 0 0 0 1 30 0 0 0 1</matrix>
        <node><rotate>0 0 1 90</rotate><instance_geometry url='#g'/></node></node></visual_scene>
      </library_visual_scenes>
    </COLLADA>"""
    (tmp_path / "box.dae").write_text(text)
    room = read(tmp_path, model(mesh("box.dae")))
    (thing,) = room.obstacles
    assert thing.position == pytest.approx((1, 0, 0.3))
    assert np.ptp(thing.points, axis=0) == pytest.approx((0.4, 1.0, 0.6))
    (tmp_path / "box.dae").write_text(text.replace("polylist", "tristrips"))
    assert "COLLADA's tristrips is not read" in read(tmp_path, model(mesh("box.dae"))).omitted[0]


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.stl", stl(box_mesh((1, 1, 1)))[:-7]),
        ("a.stl", b"solid a\nvertex 1 2\nendsolid"),
        ("a.stl", stl(box_mesh((np.nan, 1, 1)))),
        ("a.stl", stl(np.zeros((4, 3, 3)))),
        ("a.obj", b"v 0 0 0\nf 1 2 3"),
        ("a.obj", b"v 0 0\nf 1 2 3"),
        ("a.obj", b"v 1e300 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3"),
        ("a.obj", b"v 0 0 0\nf 1 999999999999999999999999 1"),
        ("a.obj", b"\x00\xff\x80rubbish"),
        ("a.dae", b"<COLLADA><library_visual_scenes><visual_scene><instance_geometry url='#x'/></visual_scene>"),
        ("a.dae", b"<!DOCTYPE x [<!ENTITY a 'b'>]><COLLADA/>"),
        ("a.ply", b"ply"),
        ("a.txt/../../a.stl", b""),
    ],
)
def test_a_broken_mesh_is_named(tmp_path: Path, name: str, data: bytes) -> None:
    if "/" not in name:
        (tmp_path / name).write_bytes(data)
    room = read(tmp_path, model(mesh(name), name="thing"))
    assert not room.obstacles
    assert len(room.omitted) == 1
    assert room.omitted[0].startswith(f"'thing': the mesh {name} is left out: ")


def test_nothing_outside_of_the_folders_is_read(tmp_path: Path) -> None:
    (tmp_path / "inside").mkdir()
    (tmp_path / "box.stl").write_bytes(stl(box_mesh((1, 1, 1))))
    (tmp_path / "inside" / "link.stl").symlink_to(tmp_path / "box.stl")
    write_model(tmp_path, f"<link name='l'>{collision()}</link>", "outside")
    uris = ["link.stl", "../box.stl", f"file://{tmp_path}/box.stl", "model://../box.stl"]
    things = "".join(model(mesh(uri), name=f"m{i}") for i, uri in enumerate(uris))
    room = read(tmp_path / "inside", things + "<include><uri>model://../outside</uri></include>")
    assert not room.obstacles
    assert len(room.omitted) == 5
    assert all("lies outside of" in sentence for sentence in room.omitted)


# Hostile files --------------------------------------------------------------------------------------------------------

LAUGHS = "<!DOCTYPE sdf [<!ENTITY a 'ha'>" + "".join(
    f"<!ENTITY {chr(98 + i)} '{f'&{chr(97 + i)};' * 10}'>" for i in range(10)
)


@pytest.mark.parametrize(
    "text",
    [
        LAUGHS + "]><sdf version='1.6'><world name='&j;'/></sdf>",
        "<!DOCTYPE sdf SYSTEM 'file:///etc/hostname'><sdf version='1.6'/>",
        "<sdf version='1.6'><world name='w'>&undefined;</world></sdf>",
        "<sdf version='1.6'><world name='w'><model",
        "",
        "\x00\x01\x02",
        "<robot name='urdf'/>",
        "<sdf version='1.6'/>",
        "<sdf><world name='w'/></sdf>",
        "<sdf version='1.2'><world name='w'/></sdf>",
        "<sdf version='9999999999999999.1'><world name='w'/></sdf>",
        "<?xml version='1.0' encoding='shift_jis'?><sdf version='1.6'/>",
        "<?xml version='1.0' encoding='hex'?><sdf version='1.6'/>",
        "<?xml version='1.0' encoding='none'?><sdf version='1.6'/>",
        "<sdf version='1.6'>" + "<model>" * 150 + "</model>" * 150 + "</sdf>",
        "<sdf version='1.6'>" + "<model name='m'>" * 50 + "</model>" * 50 + "</sdf>",
        "<sdf version='1.6'><world>" + "<model name='m'/>" * 100_000 + "</world></sdf>",
        "<sdf version='1.6'>" + "<a/>" * 600_000 + "</sdf>",
        "<sdf version='1.6'>" + " " * 20_000_000 + "</sdf>",
    ],
)
def test_a_hostile_file_ends_in_one_sentence(tmp_path: Path, text: str) -> None:
    path = tmp_path / "room.world"
    path.write_text(text)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(TaskError, match="room.world") as error:
        read_world(path)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 250_000  # kB
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 500
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("size", ["nan 1 1", "inf 1 1", "-1 1 1", "0 1 1", "1 1", "1 1 1 1", "a b c", "1e300 1 1", ""])
def test_an_invalid_size_ends_in_one_sentence(tmp_path: Path, size: str) -> None:
    with pytest.raises(TaskError, match="the size of the box 'thing' is"):
        read(tmp_path, model(collision(f"<geometry><box><size>{size}</size></box></geometry>")))


@pytest.mark.parametrize("pose", ["nan 0 0 0 0 0", "0 0 0", "0 0 0 0 0 1e99", "x", "0 " * 10_000])
def test_an_invalid_pose_ends_in_one_sentence(tmp_path: Path, pose: str) -> None:
    with pytest.raises(TaskError, match="the pose of the model 'thing' is .* but must be 6 numbers"):
        read(tmp_path, model(collision(), pose))


@pytest.mark.parametrize("mass", ["nan", "0", "-1", "1e300"])
def test_an_invalid_mass_ends_in_one_sentence(tmp_path: Path, mass: str) -> None:
    inside = f"<inertial><mass>{mass}</mass></inertial>{collision()}"
    with pytest.raises(TaskError, match="the mass of 'thing' is"):
        read(tmp_path, model(inside, static=False))


def test_models_that_include_one_another_end_in_one_sentence(tmp_path: Path) -> None:
    write_model(tmp_path, "<include><uri>model://b</uri></include>", "a")
    write_model(tmp_path, "<include><uri>model://a</uri></include>", "b")
    with pytest.raises(TaskError, match="the model model://a includes itself"):
        read(tmp_path, "<include><uri>model://a</uri></include>")


def test_models_that_multiply_end_in_one_sentence(tmp_path: Path) -> None:
    for i in range(15):
        write_model(tmp_path, f"<include><uri>model://m{i + 1}</uri></include>" * 20, f"m{i}")
    write_model(tmp_path, "", "m15")
    with pytest.raises(TaskError, match="more than 20,000 models"):
        read(tmp_path, "<include><uri>model://m0</uri></include>")


def test_a_long_chain_of_frames_ends_in_one_sentence(tmp_path: Path) -> None:
    frames = "".join(f"<frame name='{i}'><pose relative_to='{i + 1}'/></frame>" for i in range(5_000))
    link = f"<link name='link'><pose relative_to='0'/>{collision()}</link>"
    assert "leads back to itself or too far" in read(tmp_path, model(link + frames)).omitted[0]


def test_twenty_thousand_obstacles_and_two_thousand_hulls_are_the_most(tmp_path: Path) -> None:
    with pytest.raises(TaskError, match="more than 20,000 obstacles"):
        read(tmp_path, model("".join(f"<link name='l'>{collision() * 200}</link>" for _ in range(101))))
    capsule = "<geometry><capsule><radius>1</radius><length>1</length></capsule></geometry>"
    with pytest.raises(TaskError, match="more than 2,000 convex hulls"):
        read(tmp_path, model(collision(capsule) * 2_001))


def test_a_missing_file_and_a_folder_end_in_one_sentence(tmp_path: Path) -> None:
    for path in (tmp_path / "none.world", tmp_path, Path("/dev/zero"), tmp_path / ("x" * 5000)):
        with pytest.raises(TaskError, match="file"):
            read_world(path)
