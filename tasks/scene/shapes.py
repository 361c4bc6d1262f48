"""The visible geoms and sites of a compiled scene, as plain shapes in the frames of their bodies."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from tasks.physics import FloatArray

WORLD = "world"
VISIBLE_GROUPS = 3  # MuJoCo's viewers and pictures show the groups 0, 1 and 2
_PLANE_MARGIN = 1.0  # m that an infinite plane is drawn beyond the scene
_PLANE_THICKNESS = 0.01  # m
_DEFAULT_COLOUR = np.array([0.5, 0.5, 0.5, 1.0], dtype=np.float32)  # of a geom without one in the file


class Shape(StrEnum):
    """Kinds of shape."""

    BOX = "box"
    ELLIPSOID = "ellipsoid"
    CYLINDER = "cylinder"
    MESH = "mesh"


@dataclass(frozen=True)
class Part:
    """A shape to draw.

    Attributes:
        owner: name of its body, moving or not.
        frame: name of the frame it is fixed to: its body's, or the world where the body does not move.
        shape: its kind.
        position: (3,) metres, of its middle, in the frame.
        quaternion: (4,) w, x, y, z, in the frame.
        size: (3,) metres, full extents along its own axes; of a cylinder along z. Ones for a mesh.
        rgba: (4,) from 0 to 1.
        vertices: (n, 3) metres, of a mesh.
        faces: (m, 3) indices into the vertices, of a mesh.
    """

    owner: str
    frame: str
    shape: Shape
    position: FloatArray
    quaternion: FloatArray
    size: FloatArray
    rgba: FloatArray
    vertices: npt.NDArray[np.float32] | None = None
    faces: npt.NDArray[np.int32] | None = None


def body_name(model: mujoco.MjModel, body: int) -> str:
    """Name of a body, from its number where the file gives none."""
    name: str = model.body(body).name
    return name or f"body_{body}"


def moves(model: mujoco.MjModel, body: int) -> bool:
    """Whether a body can move: by a joint above it, or as a mocap body."""
    return bool(model.body_weldid[body] != 0 or model.body_mocapid[model.body_rootid[body]] >= 0)


def scene_parts(model: mujoco.MjModel) -> list[Part]:
    """Every visible geom and site of a scene; a capsule is three parts."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    elements = [(model.geom(index), data.geom(index)) for index in range(model.ngeom)]
    elements += [(model.site(index), data.site(index)) for index in range(model.nsite)]
    return [
        part
        for element, at_rest in elements
        if element.group[0] < VISIBLE_GROUPS and (rgba := _colour(model, element))[3] > 0
        for part in _shaped(model, data, element, _placed(model, element, at_rest, rgba))
    ]


def _placed(model: mujoco.MjModel, element: Any, at_rest: Any, rgba: FloatArray) -> Part:
    """A box around a geom or site, where it is."""
    body, size = int(element.bodyid[0]), 2 * np.array(element.size)
    owner = body_name(model, body)
    if moves(model, body):
        return Part(owner, owner, Shape.BOX, np.array(element.pos), np.array(element.quat), size, rgba)
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, at_rest.xmat)
    return Part(owner, WORLD, Shape.BOX, np.array(at_rest.xpos), quaternion, size, rgba)


def _shaped(model: mujoco.MjModel, data: mujoco.MjData, element: Any, box: Part) -> Iterator[Part]:
    """The box replaced by the shape of the geom or site."""
    width, length, _ = box.size
    ball = replace(box, shape=Shape.ELLIPSOID, size=np.full(3, width))
    cylinder = replace(box, shape=Shape.CYLINDER, size=np.array([width, width, length]))
    match mujoco.mjtGeom(int(element.type[0])):
        case mujoco.mjtGeom.mjGEOM_BOX:
            yield box
        case mujoco.mjtGeom.mjGEOM_SPHERE:
            yield ball
        case mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            yield replace(box, shape=Shape.ELLIPSOID)
        case mujoco.mjtGeom.mjGEOM_CYLINDER:
            yield cylinder
        case mujoco.mjtGeom.mjGEOM_CAPSULE:
            yield from (cylinder, _raised(ball, -length / 2), _raised(ball, length / 2))
        case mujoco.mjtGeom.mjGEOM_PLANE:
            extents = np.array([width or _reach(model, data), length or _reach(model, data), _PLANE_THICKNESS])
            yield _raised(replace(box, size=extents), -_PLANE_THICKNESS / 2)
        case mujoco.mjtGeom.mjGEOM_MESH:
            mesh = model.mesh(int(element.dataid[0]))
            faces = model.mesh_face[mesh.faceadr[0] : mesh.faceadr[0] + mesh.facenum[0]]
            vertices = model.mesh_vert[mesh.vertadr[0] : mesh.vertadr[0] + mesh.vertnum[0]]
            yield replace(box, shape=Shape.MESH, size=np.ones(3), vertices=np.array(vertices), faces=np.array(faces))


def _raised(part: Part, height: float) -> Part:
    """The part moved along its own z axis, metres."""
    offset = np.empty(3)
    mujoco.mju_rotVecQuat(offset, np.array([0.0, 0.0, height]), part.quaternion)
    return replace(part, position=part.position + offset)


def _reach(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Side of a square that holds every finite geom, metres."""
    finite = model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE
    reach = np.abs(data.geom_xpos[finite, :2]).max(axis=1) + model.geom_rbound[finite]
    return 2 * (float(reach.max(initial=1.0)) + _PLANE_MARGIN)


def _colour(model: mujoco.MjModel, element: Any) -> FloatArray:
    """Colour of a geom or site: its own, or else its material's times the texture's mean."""
    material = int(element.matid[0])
    if material < 0 or not np.array_equal(element.rgba, _DEFAULT_COLOUR):
        return np.array(element.rgba, dtype=np.float64)
    rgba = np.array(model.mat_rgba[material], dtype=np.float64)
    texture = int(model.mat_texid[material, int(mujoco.mjtTextureRole.mjTEXROLE_RGB)])
    if texture >= 0:
        channels, start = int(model.tex_nchannel[texture]), int(model.tex_adr[texture])
        count = int(model.tex_height[texture]) * int(model.tex_width[texture]) * channels
        pixels = np.asarray(model.tex_data[start : start + count]).reshape(-1, channels)
        rgba[:3] *= pixels.mean(axis=0)[[0, 0, 0] if channels < 3 else [0, 1, 2]] / 255
    return rgba
