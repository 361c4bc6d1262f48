"""The visible geoms and sites of a compiled scene, as plain shapes in the frames of their bodies."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

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
    at_rest = mujoco.MjData(model)
    mujoco.mj_kinematics(model, at_rest)
    scene = _Scene(model, at_rest)
    return [*scene.geoms(), *scene.sites()]


@dataclass(frozen=True)
class _Scene:
    model: mujoco.MjModel
    data: mujoco.MjData

    def geoms(self) -> Iterator[Part]:
        model = self.model
        for geom in range(model.ngeom):
            rgba = self._colour(model.geom_rgba[geom], int(model.geom_matid[geom]))
            if model.geom_group[geom] < VISIBLE_GROUPS and rgba[3] > 0:
                placed = self._placed(
                    int(model.geom_bodyid[geom]),
                    (model.geom_pos[geom], model.geom_quat[geom]),
                    (self.data.geom_xpos[geom], self.data.geom_xmat[geom]),
                )
                yield from self._shaped(
                    placed, int(model.geom_type[geom]), model.geom_size[geom], rgba, int(model.geom_dataid[geom])
                )

    def sites(self) -> Iterator[Part]:
        model = self.model
        for site in range(model.nsite):
            rgba = self._colour(model.site_rgba[site], int(model.site_matid[site]))
            if model.site_group[site] < VISIBLE_GROUPS and rgba[3] > 0:
                placed = self._placed(
                    int(model.site_bodyid[site]),
                    (model.site_pos[site], model.site_quat[site]),
                    (self.data.site_xpos[site], self.data.site_xmat[site]),
                )
                yield from self._shaped(placed, int(model.site_type[site]), model.site_size[site], rgba, -1)

    def _placed(
        self, body: int, in_body: tuple[FloatArray, FloatArray], in_world: tuple[FloatArray, FloatArray]
    ) -> "_Pose":
        owner = body_name(self.model, body)
        if moves(self.model, body):
            return _Pose(owner, owner, *(np.array(value) for value in in_body))
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, in_world[1])
        return _Pose(owner, WORLD, np.array(in_world[0]), quaternion)

    def _shaped(self, place: "_Pose", kind: int, size: FloatArray, rgba: FloatArray, data_id: int) -> Iterator[Part]:
        radius, second, _ = (float(value) for value in size)
        match mujoco.mjtGeom(kind):
            case mujoco.mjtGeom.mjGEOM_BOX:
                yield place.part(Shape.BOX, 2 * np.array(size), rgba)
            case mujoco.mjtGeom.mjGEOM_SPHERE:
                yield place.part(Shape.ELLIPSOID, np.full(3, 2 * radius), rgba)
            case mujoco.mjtGeom.mjGEOM_ELLIPSOID:
                yield place.part(Shape.ELLIPSOID, 2 * np.array(size), rgba)
            case mujoco.mjtGeom.mjGEOM_CYLINDER:
                yield place.part(Shape.CYLINDER, 2 * np.array([radius, radius, second]), rgba)
            case mujoco.mjtGeom.mjGEOM_CAPSULE:
                yield place.part(Shape.CYLINDER, 2 * np.array([radius, radius, second]), rgba)
                for end in (-second, second):
                    yield place.moved(np.array([0, 0, end])).part(Shape.ELLIPSOID, np.full(3, 2 * radius), rgba)
            case mujoco.mjtGeom.mjGEOM_PLANE:
                extents = np.array([2 * radius or self._reach(), 2 * second or self._reach(), _PLANE_THICKNESS])
                yield place.moved(np.array([0, 0, -0.5 * _PLANE_THICKNESS])).part(Shape.BOX, extents, rgba)
            case mujoco.mjtGeom.mjGEOM_MESH:
                vertices, faces = self._mesh(data_id)
                yield place.part(Shape.MESH, np.ones(3), rgba, vertices, faces)

    def _mesh(self, mesh: int) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int32]]:
        model = self.model
        vertex, face = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
        vertices = model.mesh_vert[vertex : vertex + int(model.mesh_vertnum[mesh])]
        return np.array(vertices), np.array(model.mesh_face[face : face + int(model.mesh_facenum[mesh])])

    def _reach(self) -> float:
        """Side of a square that holds every finite geom, metres."""
        finite = self.model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE
        reach = np.abs(self.data.geom_xpos[finite, :2]).max(axis=1) + self.model.geom_rbound[finite]
        return 2 * (float(reach.max(initial=1.0)) + _PLANE_MARGIN)

    def _colour(self, own: npt.NDArray[np.float32], material: int) -> FloatArray:
        """Colour of a geom or site: its own, or else its material's times the texture's mean."""
        if material < 0 or not np.array_equal(own, _DEFAULT_COLOUR):
            return np.array(own, dtype=np.float64)
        rgba = np.array(self.model.mat_rgba[material], dtype=np.float64)
        texture = int(self.model.mat_texid[material, int(mujoco.mjtTextureRole.mjTEXROLE_RGB)])
        if texture >= 0:
            rgba[:3] *= self._mean_of_texture(texture)
        return rgba

    def _mean_of_texture(self, texture: int) -> FloatArray:
        model = self.model
        channels = int(model.tex_nchannel[texture])
        start = int(model.tex_adr[texture])
        count = int(model.tex_height[texture]) * int(model.tex_width[texture]) * channels
        pixels = np.asarray(model.tex_data[start : start + count]).reshape(-1, channels)
        mean: FloatArray = pixels.mean(axis=0)[[0, 0, 0] if channels < 3 else [0, 1, 2]] / 255
        return mean


@dataclass(frozen=True)
class _Pose:
    owner: str
    frame: str
    position: FloatArray
    quaternion: FloatArray

    def moved(self, offset: FloatArray) -> "_Pose":
        """The pose moved along its own axes, metres."""
        turned = np.empty(3)
        mujoco.mju_rotVecQuat(turned, offset.astype(np.float64), self.quaternion)
        return _Pose(self.owner, self.frame, self.position + turned, self.quaternion)

    def part(
        self,
        shape: Shape,
        size: FloatArray,
        rgba: FloatArray,
        vertices: npt.NDArray[np.float32] | None = None,
        faces: npt.NDArray[np.int32] | None = None,
    ) -> Part:
        return Part(self.owner, self.frame, shape, self.position, self.quaternion, size, rgba, vertices, faces)
