"""Small rooms for tests, and free space and shortest paths by Shapely, independent of the tasks' code."""

from itertools import product
from typing import Any

import mujoco
import networkx
import numpy as np
import numpy.typing as npt
import shapely
from shapely.geometry.polygon import orient

from tasks.scene.loading import MODELS

WALLS = """
<geom name="east" type="box" pos="3.05 0 0.25" size="0.05 3.1 0.25"/>
<geom name="north" type="box" pos="0 3.05 0.25" size="3.1 0.05 0.25"/>
<geom name="west" type="box" pos="-3.05 0 0.25" size="0.05 3.1 0.25"/>
<geom name="south" type="box" pos="0 -3.05 0.25" size="3.1 0.05 0.25"/>
"""


def room(things: str = "", walls: str = WALLS, assets: str = "") -> mujoco.MjModel:
    """A room of 6 x 6 m with the robot at the origin and `things`, MJCF."""
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><include file="{MODELS}/rooms/common.xml"/><include file="{MODELS}/pioneer/pioneer.xml"/>'
        f"<asset>{assets}</asset><worldbody>{walls}{things}</worldbody></mujoco>"
    )


def free_pieces(model: mujoco.MjModel, radius: float, low: float = 0.001, high: float = 0.307) -> list[shapely.Polygon]:
    """Pieces of the floor in which a disk's centre can move, by Shapely.

    Disks are taken as polygons within them, so that the pieces are up to a few millimetres too large.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    base = model.body("base").id
    shadows = [
        shadow
        for geom in range(model.ngeom)
        if model.geom_contype[geom]
        and model.body_rootid[model.geom_bodyid[geom]] != base
        and geom != model.geom("floor").id
        and (shadow := _shadow(model, data, geom, low, high)) is not None
    ]
    extent = shapely.box(*shapely.union_all(shadows).bounds)
    free = extent.difference(shapely.union_all(shadows).buffer(radius, quad_segs=4))
    return [piece for piece in shapely.get_parts(free) if piece.area > 1e-6]


def _shadow(model: Any, data: Any, geom: int, low: float, high: float) -> Any:
    """The shadow of a box, or of an upright cylinder."""
    kind, size = model.geom_type[geom], model.geom_size[geom]
    position, rotation = data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        corners = np.array(list(product((-1, 1), repeat=3))) * size @ rotation.T + position
        shadow = shapely.MultiPoint(corners[:, :2]).convex_hull
    else:
        assert kind == mujoco.mjtGeom.mjGEOM_CYLINDER
        assert rotation[2, 2] > 1 - 1e-9
        corners = position + np.array([[0, 0, -size[1]], [0, 0, size[1]]])
        shadow = shapely.Point(position[:2]).buffer(size[0])
    return shadow if corners[:, 2].max() > low and corners[:, 2].min() < high else None


class VisibilityGraph:
    """Exact shortest paths in a polygon with holes: they bend only at its corners."""

    def __init__(self, piece: shapely.Polygon, longest: float) -> None:
        """Join the corners that see each other, up to `longest` metres apart."""
        # A small slack, so that paths along an edge lie in the polygon.
        self._room = piece.buffer(1e-6)
        shapely.prepare(self._room)
        self._longest = longest
        self._corners = np.concatenate(_bends(piece))
        self._graph = networkx.Graph()
        first, second = np.triu_indices(len(self._corners), 1)
        self._join(self._graph, self._corners, first, second)

    def length(self, start: tuple[float, float], goal: tuple[float, float]) -> float:
        """Length of the shortest path, metres."""
        count = len(self._corners)
        points = np.concatenate([self._corners, [start, goal]])
        graph = self._graph.copy()
        for end in (count, count + 1):
            self._join(graph, points, np.full(end, end), np.arange(end))
        return float(networkx.dijkstra_path_length(graph, count, count + 1))

    def _join(self, graph: Any, points: Any, first: Any, second: Any) -> None:
        lengths = np.hypot(*(points[first] - points[second]).T)
        near = lengths <= self._longest
        first, second, lengths = first[near], second[near], lengths[near]
        sight = shapely.covers(self._room, shapely.linestrings(np.stack([points[first], points[second]], axis=1)))
        graph.add_weighted_edges_from(zip(first[sight], second[sight], lengths[sight], strict=True))


def _bends(piece: shapely.Polygon) -> list[npt.NDArray[np.float64]]:
    """The corners at which a shortest path may bend: those with more than 180 degrees of free space."""
    # Outer ring counter-clockwise, holes clockwise: free space lies to the left, such corners turn right.
    piece = orient(piece)
    bends = []
    for ring in (piece.exterior, *piece.interiors):
        corners = np.array(ring.coords)[:-1]
        before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
        bends.append(corners[before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] < 0])
    return bends
