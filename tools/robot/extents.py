"""How far geoms reach: the support function of MuJoCo's shapes."""

from collections.abc import Sequence

import mujoco
import numpy as np

from tasks.physics import FloatArray

AZIMUTHS = 3600  # directions a circumscribed circle is looked for in; off by less than a millionth of its radius


def reach(model: mujoco.MjModel, data: mujoco.MjData, geom: int, direction: FloatArray) -> float:
    """Largest coordinate along a unit vector, (3,) world frame, that a geom's surface has; metres.

    Raises:
        ValueError: a shape without end or of no known form, such as a plane.
    """
    local = data.geom_xmat[geom].reshape(3, 3).T @ direction
    return float(data.geom_xpos[geom] @ direction) + _half_reach(model, geom, local)


def _half_reach(model: mujoco.MjModel, geom: int, local: FloatArray) -> float:
    shape, size = mujoco.mjtGeom(int(model.geom_type[geom])), model.geom_size[geom]
    match shape:
        case mujoco.mjtGeom.mjGEOM_SPHERE:
            return float(size[0])
        case mujoco.mjtGeom.mjGEOM_CAPSULE:
            return float(size[0] + size[1] * abs(local[2]))
        case mujoco.mjtGeom.mjGEOM_CYLINDER:
            return float(size[0] * np.hypot(local[0], local[1]) + size[1] * abs(local[2]))
        case mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            return float(np.linalg.norm(size * local))
        case mujoco.mjtGeom.mjGEOM_BOX:
            return float(size @ np.abs(local))
        case mujoco.mjtGeom.mjGEOM_MESH:
            mesh = int(model.geom_dataid[geom])
            start = int(model.mesh_vertadr[mesh])
            return float(np.max(model.mesh_vert[start : start + int(model.mesh_vertnum[mesh])] @ local))
    raise ValueError(f"the geom {model.geom(geom).name!r} is a {shape.name[7:].lower()}, whose reach is unknown")


def extent(
    model: mujoco.MjModel, data: mujoco.MjData, geoms: Sequence[int], direction: FloatArray
) -> tuple[float, float]:
    """Least and largest coordinate of some geoms along a unit vector, (3,) world frame; metres."""
    low = -max(reach(model, data, geom, -direction) for geom in geoms)
    return low, max(reach(model, data, geom, direction) for geom in geoms)


def circumscribed_radius(model: mujoco.MjModel, data: mujoco.MjData, geoms: Sequence[int]) -> float:
    """Radius of the least circle about the world's z axis that holds some geoms seen from above; metres."""
    angles = np.linspace(-np.pi, np.pi, AZIMUTHS, endpoint=False)
    directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(AZIMUTHS)], axis=1)
    return max(reach(model, data, geom, direction) for geom in geoms for direction in directions)
