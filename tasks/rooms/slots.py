"""Rooms that change at run time: slots for obstacles in one compiled scene.

To compile a room takes 4 to 7 ms, and a scene of its own for each of the robots' episodes more. Here a scene with many
boxes is compiled once, and an episode's obstacles are written into its geoms. MuJoCo finds contacts with fixed geoms by
a tree of bounding boxes; geoms that are moved leave it stale, and contacts are missed without a word. So the tree's
boxes are computed again, from its leaves up.
"""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from tasks.errors import TaskError
from tasks.physics import FloatArray
from tasks.rooms.fence import find_axes
from tasks.rooms.room import Obstacle, Shape

NAME = "slot_"
PARKED = -10.0  # m, height of the geoms that no obstacle needs
_TYPES = {
    Shape.BOX: mujoco.mjtGeom.mjGEOM_BOX,
    Shape.CYLINDER: mujoco.mjtGeom.mjGEOM_CYLINDER,
    Shape.SPHERE: mujoco.mjtGeom.mjGEOM_SPHERE,
}

_VISIBLE, _HIDDEN = (0.5, 0.5, 0.5, 1.0), (0.5, 0.5, 0.5, 0.0)  # a beam passes what is wholly transparent

IntArray = npt.NDArray[np.intp]


class Level(NamedTuple):
    """Nodes of one depth of the tree, and the two children of each: (n,) each."""

    nodes: IntArray
    first: IntArray
    second: IntArray


def add_slots(spec: mujoco.MjSpec, count: int) -> None:
    """Add so many slots to a scene."""
    for number in range(count):
        geom = spec.worldbody.add_geom(spec.find_default("obstacle"), name=f"{NAME}{number:03d}")
        geom.type, geom.size, geom.pos = mujoco.mjtGeom.mjGEOM_BOX, (0.1, 0.1, 0.1), (number, 0.0, PARKED)


class Slots:
    """The slots of a compiled scene."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Find them in a model; all are empty."""
        self.model = model
        names = [model.geom(geom).name for geom in range(model.ngeom)]
        geoms = {geom for geom, name in enumerate(names) if name.startswith(NAME)}
        begin, count = int(model.body_bvhadr[0]), int(model.body_bvhnum[0])
        found = model.bvh_nodeid[begin : begin + count]
        # In the order of the leaves: neighbours in it are neighbours in the tree.
        leaves = [node for node in _depth_first(model) if int(found[node]) in geoms]
        self._leaves = np.array(leaves) + begin
        self._geoms = np.array([int(found[node]) for node in leaves])
        self._levels = _find_levels(model)
        self._material = int(model.material("obstacle").id)
        self._occupied = len(self._geoms)
        model.geom_sameframe[self._geoms] = mujoco.mjtSameFrame.mjSAMEFRAME_NONE
        self.fill(())

    @property
    def count(self) -> int:
        """Obstacles that find a place."""
        return len(self._geoms)

    def fill(self, obstacles: Sequence[Obstacle]) -> tuple[FloatArray, FloatArray]:
        """Put obstacles into the slots, in place of those before; movable ones stand fast.

        The model's data are stale until the next mj_forward or reset.

        Returns:
            Corners of the smallest rectangle around them, metres; about the origin without any.

        Raises:
            TaskError: there are more obstacles than slots, or one is a hull.
        """
        count, model = len(obstacles), self.model
        if count > self.count:
            raise TaskError(f"a room that changes at run time has up to {self.count} obstacles, not {count}")
        table = np.array([_describe(each) for each in obstacles]).reshape(count, 11)
        table = table[_order(table[:, 1:3])]
        geoms = self._geoms[:count]
        types, places, quaternions, sizes = table[:, 0].astype(np.int32), table[:, 1:4], table[:, 4:8], table[:, 8:]
        model.geom_type[geoms] = types
        model.geom_pos[geoms], model.geom_quat[geoms], model.geom_size[geoms] = places, quaternions, sizes
        half = _half_sides(types, sizes)
        model.geom_aabb[geoms, 3:] = half
        model.geom_rbound[geoms] = _radii(sizes)
        self._show(count)
        reach = _rotated(half, quaternions)
        self._refit(places, reach)
        if not count:
            return np.zeros(2), np.zeros(2)
        return (places - reach)[:, :2].min(axis=0), (places + reach)[:, :2].max(axis=0)

    def _show(self, count: int) -> None:
        """Let the first geoms be seen and touched, and no other."""
        model = self.model
        appearing, parked = self._geoms[self._occupied : count], self._geoms[count : self._occupied]
        for geoms, mask, material, colour in ((appearing, 1, self._material, _VISIBLE), (parked, 0, -1, _HIDDEN)):
            model.geom_contype[geoms], model.geom_conaffinity[geoms] = mask, mask
            model.geom_matid[geoms], model.geom_rgba[geoms] = material, colour
        model.geom_pos[parked] = [0.0, 0.0, PARKED]
        self._occupied = count

    def _refit(self, centres: FloatArray, half: FloatArray) -> None:
        """Bounding boxes of the leaves, and of all nodes above them.

        An empty leaf gets the box of the last obstacle, so that it enlarges no node above; contacts ignore its geom.
        """
        boxes = self.model.bvh_aabb
        leaves, count = self._leaves, len(centres)
        boxes[leaves, :3] = boxes[leaves, 3:] = 0.0
        if count:
            boxes[leaves[:count]] = np.concatenate([centres, half], axis=1)
            boxes[leaves[count:]] = boxes[leaves[count - 1]]
        low, high = boxes[:, :3] - boxes[:, 3:], boxes[:, :3] + boxes[:, 3:]
        for nodes, first, second in self._levels:
            low[nodes], high[nodes] = np.minimum(low[first], low[second]), np.maximum(high[first], high[second])
            boxes[nodes, :3], boxes[nodes, 3:] = (high[nodes] + low[nodes]) / 2, (high[nodes] - low[nodes]) / 2


def _depth_first(model: mujoco.MjModel) -> list[int]:
    """Nodes of the world's tree, from the left to the right; children's numbers count from its first node."""
    waiting, order = [0], []
    begin = int(model.body_bvhadr[0])
    children = model.bvh_child[begin : begin + int(model.body_bvhnum[0])].tolist()
    while waiting:
        node = waiting.pop()
        order.append(node)
        waiting += [child for child in reversed(children[node]) if child >= 0]
    return order


def _find_levels(model: mujoco.MjModel) -> list[Level]:
    """The inner nodes of the world's tree by depth, the deepest first."""
    begin, count = int(model.body_bvhadr[0]), int(model.body_bvhnum[0])
    depth, children = model.bvh_depth[begin : begin + count], model.bvh_child[begin : begin + count]
    inner = children[:, 0] >= 0
    levels = []
    for each in range(int(depth.max()), -1, -1):
        nodes = np.flatnonzero(inner & (depth == each))
        if len(nodes):
            levels.append(Level(nodes + begin, *(children[nodes].T.astype(np.intp) + begin)))
    return levels


def _describe(obstacle: Obstacle) -> tuple[float, ...]:
    """Type, position, quaternion and size in a row."""
    if obstacle.shape is Shape.HULL:
        raise TaskError("a room that changes at run time is made of boxes, cylinders and spheres, not of hulls")
    size = obstacle.size + (0.0,) * (3 - len(obstacle.size))
    return (float(_TYPES[obstacle.shape]), *obstacle.position, *obstacle.quaternion, *size)


def _order(places: FloatArray) -> IntArray:
    """An order of places, (n, 2) metres, in which neighbours lie side by side: along Morton's curve."""
    if not len(places):
        return np.zeros(0, np.intp)
    low = places.min(axis=0)
    cells = ((places - low) * (255.0 / max(float(np.ptp(places, axis=0).max()), 1e-9))).astype(np.int64)
    for shift, mask in ((4, 0x0F0F), (2, 0x3333), (1, 0x5555)):
        cells = (cells | (cells << shift)) & mask
    return np.argsort(cells[:, 0] | (cells[:, 1] << 1), kind="stable")


def _half_sides(types: npt.NDArray[np.int32], sizes: FloatArray) -> FloatArray:
    """Half the sides of each geom's bounding box in its own frame, (n, 3)."""
    cylinders, spheres = types == mujoco.mjtGeom.mjGEOM_CYLINDER, types == mujoco.mjtGeom.mjGEOM_SPHERE
    half = sizes.copy()
    half[cylinders, 1:] = sizes[cylinders, :2]
    half[spheres] = sizes[spheres, :1]
    return half


def _radii(sizes: FloatArray) -> FloatArray:
    """Radius of the sphere around each geom, (n,)."""
    radii: FloatArray = np.linalg.norm(sizes, axis=1)  # of a cylinder too: its third size is 0
    return radii


def _rotated(half: FloatArray, quaternions: FloatArray) -> FloatArray:
    """Half the sides of the boxes along the world's axes around boxes of these halves, (n, 3)."""
    reach: FloatArray = (np.abs(find_axes(quaternions)) * half[:, None]).sum(axis=2)
    return reach
