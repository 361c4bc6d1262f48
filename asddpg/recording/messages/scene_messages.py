"""Foxglove's SceneUpdate of a scene."""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

from foxglove.messages import (
    Color,
    CubePrimitive,
    CylinderPrimitive,
    Point3,
    Pose,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    SpherePrimitive,
    TriangleListPrimitive,
    Vector3,
)

from asddpg.recording.messages.goal_camera_messages import round_to_grid
from tasks.scene.shapes import Part, Shape, scene_parts

Point = tuple[float, float]  # x, y in metres, world frame


def scene_message(model: Any) -> bytes:
    """/scene of a compiled model: one message, an entity a body, fixed to its frame, so that only /tf moves it."""
    by_body: dict[tuple[str, str], list[Part]] = defaultdict(list)
    for part in scene_parts(model):
        by_body[part.owner, part.frame].append(part)
    entities = [_entity(owner, frame, own) for (owner, frame), own in by_body.items()]
    encoded: bytes = SceneUpdate(entities=entities).encode()
    return encoded


def _entity(owner: str, frame: str, parts: Sequence[Part]) -> SceneEntity:
    def primitives(shape: Shape, primitive: Any, **options: float) -> list[Any]:
        own = (part for part in parts if part.shape is shape)
        return [primitive(pose=_pose(part), size=_size(part), color=_colour(part), **options) for part in own]

    return SceneEntity(
        id=owner,
        frame_id=frame,
        frame_locked=True,
        cubes=primitives(Shape.BOX, CubePrimitive),
        spheres=primitives(Shape.ELLIPSOID, SpherePrimitive),
        # Scales of 0, their default, would make it a point.
        cylinders=primitives(Shape.CYLINDER, CylinderPrimitive, bottom_scale=1.0, top_scale=1.0),
        triangles=[_triangles(part) for part in parts if part.shape is Shape.MESH],
    )


def _pose(part: Part) -> Pose:
    x, y, z = round_to_grid(part.position).tolist()
    w, i, j, k = round_to_grid(part.quaternion).tolist()
    return Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(x=i, y=j, z=k, w=w))


def _size(part: Part) -> Vector3:
    x, y, z = round_to_grid(part.size).tolist()
    return Vector3(x=x, y=y, z=z)


def _colour(part: Part) -> Color:
    r, g, b, a = round_to_grid(part.rgba).tolist()
    return Color(r=r, g=g, b=b, a=a)


def _triangles(part: Part) -> TriangleListPrimitive:
    assert part.vertices is not None
    assert part.faces is not None
    points = [Point3(x=x, y=y, z=z) for x, y, z in round_to_grid(part.vertices).tolist()]
    return TriangleListPrimitive(
        pose=_pose(part), points=points, indices=part.faces.ravel().tolist(), color=_colour(part)
    )
