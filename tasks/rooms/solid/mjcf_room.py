"""MJCF files without a robot as rooms."""

from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from tasks.errors import TaskError
from tasks.physics import FloatArray
from tasks.rooms.room import Room, Shape
from tasks.rooms.solid.collector import Collector, quote
from tasks.rooms.solid.files import UnreadError
from tasks.rooms.solid.meshes import ellipsoid_points, reduce_to_hull
from tasks.rooms.solid.mjcf_file import read_solids
from tasks.rooms.solid.transforms import Transform

_HORIZONTAL = 0.9999  # of the vertical part of a plane's normal: a floor
_Type = mujoco.mjtGeom
_SHAPES = {
    _Type.mjGEOM_BOX: (Shape.BOX, 3),
    _Type.mjGEOM_CYLINDER: (Shape.CYLINDER, 2),
    _Type.mjGEOM_SPHERE: (Shape.SPHERE, 1),
}


def read_mjcf(path: Path) -> Room:
    """The colliding geoms of an MJCF file as a room; the project's robot and its goal are left out.

    A body with a free joint and one colliding geom is movable, with its mass. Includes and meshes may lie in the file's
    folder or below.

    Args:
        path: of the file.

    Raises:
        TaskError: the file is broken, names files elsewhere, MuJoCo refuses it, or it is beyond a limit.
    """
    collector = Collector()
    try:
        model = _compile(ElementTree.tostring(read_solids(path, collector), encoding="unicode"))
        _GeomReader(model, collector).read()
        return collector.room()
    except TaskError as error:
        if str(path) in str(error):
            raise
        raise TaskError(f"the scene {path} cannot be read: {error}") from error


def _compile(xml: str) -> mujoco.MjModel:
    try:
        return mujoco.MjSpec.from_string(xml).compile()
    except (ValueError, mujoco.FatalError) as error:
        raise TaskError(" ".join(str(error).split())) from error


class _GeomReader:
    def __init__(self, model: mujoco.MjModel, collector: Collector) -> None:
        self._model = model
        self._collector = collector
        self._data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, self._data)
        self._is_solid = (np.asarray(model.geom_contype) | np.asarray(model.geom_conaffinity)) != 0

    def read(self) -> None:
        masses = self._masses()
        for geom in range(self._model.ngeom):
            name = self._name(geom)
            if not self._is_solid[geom]:
                self._collector.omit(quote(name), "without contacts, so visual only")
                continue
            try:
                self._read_geom(geom, name, masses.get(int(self._model.geom_bodyid[geom]), 0.0))
            except UnreadError as error:
                self._collector.omit(quote(name), str(error))

    def _read_geom(self, geom: int, name: str, mass: float) -> None:
        model = self._model
        kind, size = _Type(model.geom_type[geom]), model.geom_size[geom].tolist()
        pose = Transform(self._data.geom_xmat[geom].reshape(3, 3).copy(), self._data.geom_xpos[geom].copy())
        if kind in _SHAPES:
            shape, count = _SHAPES[kind]
            self._collector.add(shape, pose, size[:count], mass=mass, name=name)
        elif kind == _Type.mjGEOM_PLANE:
            if pose.rotation[2, 2] < _HORIZONTAL:
                raise UnreadError("a plane that is not a floor is not read")
            self._collector.add_floor(quote(name), pose.position[2])
        else:
            points = reduce_to_hull(self._points(geom, kind, size))
            self._collector.add(Shape.HULL, pose, points=points, mass=mass, name=name)

    def _points(self, geom: int, kind: mujoco.mjtGeom, size: list[float]) -> FloatArray:
        """Points (n, 3) of a geom, its own frame, metres, whose hull it is for contacts."""
        if kind == _Type.mjGEOM_CAPSULE:
            return ellipsoid_points([size[0]] * 3, size[1])
        if kind == _Type.mjGEOM_ELLIPSOID:
            return ellipsoid_points(size)
        if kind != _Type.mjGEOM_MESH:
            raise UnreadError(f"the shape {kind.name.removeprefix('mjGEOM_').lower()} is not read")
        mesh = int(self._model.geom_dataid[geom])
        first, count = int(self._model.mesh_vertadr[mesh]), int(self._model.mesh_vertnum[mesh])
        return np.asarray(self._model.mesh_vert[first : first + count], dtype=np.float64)

    def _masses(self) -> dict[int, float]:
        """Masses of the movable bodies, kg; others that could move are named."""
        model, masses = self._model, {}
        solids: dict[int, list[int]] = {}  # by the body that their body moves with
        for geom in np.flatnonzero(self._is_solid).tolist():
            body = int(model.geom_bodyid[geom])
            root = int(model.body_rootid[body])
            moves_with = root if model.body_mocapid[root] >= 0 else int(model.body_weldid[body])
            solids.setdefault(moves_with, []).append(geom)
        for body, geoms in solids.items():
            root = int(model.body_rootid[body])
            joints = [
                int(model.jnt_type[joint]) for joint in np.flatnonzero(model.body_rootid[model.jnt_bodyid] == root)
            ]
            if body == 0:
                continue
            if joints != [int(mujoco.mjtJoint.mjJNT_FREE)]:
                reason = "it has joints, or moves by a programme"
            elif len(geoms) > 1:
                reason = "it consists of several solids"
            else:
                masses[int(model.geom_bodyid[geoms[0]])] = float(model.body_subtreemass[root])
                continue
            self._collector.omit(f"the mobility of {quote(model.body(body).name)}", f"{reason}, so it stands fixed")
        return masses

    def _name(self, geom: int) -> str:
        """Of a geom, or of its body; else its number."""
        body = int(self._model.geom_bodyid[geom])
        return str(self._model.geom(geom).name or (body and self._model.body(body).name) or f"geom_{geom}")
