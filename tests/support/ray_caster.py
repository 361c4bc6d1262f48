"""Analytic rays against boxes, cylinders, spheres and the floor: the reference of the laser's tests."""

import mujoco
import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]
_INSIDE = 1e-12


def lengths(origin: F64, directions: F64, model: mujoco.MjModel, data: mujoco.MjData, robot: set[int]) -> F64:
    """Distance along each ray to the nearest visible thing that is not the robot: (n,), inf where there is none.

    Args:
        origin: (3,) metres.
        directions: (n, 3), of length 1.
        model: the scene.
        data: its state.
        robot: bodies to look through.
    """
    nearest = np.full(len(directions), np.inf)
    for geom in range(model.ngeom):
        if model.geom_bodyid[geom] in robot or model.geom_rgba[geom, 3] == 0.0:
            continue
        rotation = data.geom_xmat[geom].reshape(3, 3)
        start, along = rotation.T @ (origin - data.geom_xpos[geom]), directions @ rotation
        kind, size = mujoco.mjtGeom(model.geom_type[geom]), model.geom_size[geom]
        nearest = np.minimum(nearest, _CASTERS[kind](start, along, size))
    return nearest


def _box(start: F64, along: F64, size: F64) -> F64:
    with np.errstate(divide="ignore", invalid="ignore"):
        entries, exits = (-size - start) / along, (size - start) / along
    near = np.nanmax(np.minimum(entries, exits), axis=1)
    far = np.nanmin(np.maximum(entries, exits), axis=1)
    beside = np.any((np.abs(along) < _INSIDE) & (np.abs(start) > size), axis=1)
    first = np.where(near >= 0.0, near, far)
    return np.where((near <= far) & (far >= 0.0) & ~beside, first, np.inf)


def _cylinder(start: F64, along: F64, size: F64) -> F64:
    radius, half = size[0], size[1]
    found = np.full(len(along), np.inf)
    for side in (-half, half):  # the flat ends
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (side - start[2]) / along[:, 2]
            hit = (t >= 0) & (np.hypot(*(start[:2, None] + along[:, :2].T * t)) <= radius)
        found = np.where(hit, np.minimum(found, t), found)
    a = np.sum(along[:, :2] ** 2, axis=1)
    for t in _roots(a, along[:, :2] @ start[:2], start[:2] @ start[:2] - radius**2):
        with np.errstate(invalid="ignore"):
            hit = (t >= 0) & (np.abs(start[2] + t * along[:, 2]) <= half)
        found = np.where(hit, np.minimum(found, t), found)
    return found


def _ellipsoid(start: F64, along: F64, size: F64) -> F64:
    start, along = start / size, along / size  # a sphere of radius 1 in a scaled space
    found = np.full(len(along), np.inf)
    for t in _roots(np.sum(along**2, axis=1), along @ start, float(start @ start) - 1.0):
        found = np.where(t >= 0, np.minimum(found, t), found)
    return found


def _plane(start: F64, along: F64, _: F64) -> F64:
    with np.errstate(divide="ignore", invalid="ignore"):
        t = -start[2] / along[:, 2]
    return np.where((along[:, 2] < 0) & (t >= 0), t, np.inf)


def _roots(a: F64, half_b: F64, c: float) -> tuple[F64, F64]:
    """Both solutions of a t² + 2 half_b t + c = 0, inf where there are none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(half_b**2 - a * c)
        solutions = (-half_b - root) / a, (-half_b + root) / a
    return tuple(np.where(np.isnan(t), np.inf, t) for t in solutions)  # type: ignore[return-value]


_CASTERS = {
    mujoco.mjtGeom.mjGEOM_BOX: _box,
    mujoco.mjtGeom.mjGEOM_CYLINDER: _cylinder,
    mujoco.mjtGeom.mjGEOM_SPHERE: lambda start, along, size: _ellipsoid(start, along, size[[0, 0, 0]]),
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: _ellipsoid,
    mujoco.mjtGeom.mjGEOM_PLANE: _plane,
}
