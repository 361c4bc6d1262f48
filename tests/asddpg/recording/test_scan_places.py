"""The points of a recorded scan lie on the obstacles of the recorded scene, by the recording's own times and frames."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asddpg.build import make_environment
from asddpg.command_line import train_config
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Decision, Driver, Observation
from asddpg.recording.files.reading import Recording, open_recording
from tasks.physics import FloatArray
from tests.asddpg.recording.test_recording import recorder_for
from tools.recordings.overlay import place_in_world, read_pose, read_scans

STEPS = 20


def record(folder: Path, *arguments: str) -> Recording:
    """A robot that swerves through a room of movable things."""
    config = train_config(["task=nav_gazebo", *arguments])
    environment = make_environment(config.task, config.reward)
    recorder = recorder_for(folder, environment)
    turns = np.random.default_rng(5)

    def decide(_: Observation) -> Decision:
        return Decision(np.array([0.4, turns.choice([-1.0, 1.0])], dtype=np.float32), Driver.POLICY)

    options = {"start": (-2.5, -0.5, 0.3), "goal": (2.0, 2.0)}
    run_episode(environment, FixedDriver(decide), (recorder,), options, max_steps=STEPS)
    return open_recording(next(folder.iterdir()))


def nanoseconds(stamp: Any) -> int:
    return int(stamp.seconds * 10**9 + stamp.nanos)


def distances(points: FloatArray, scene: Any, transforms: Any) -> FloatArray:
    """Metres from points, (n, 3), to the nearest surface of a box or cylinder of the room or of a movable thing."""
    parents = {each.child_frame_id: each.parent_frame_id for each in transforms}
    found = []
    for entity in scene.entities:
        if entity.id in ("base", "goal") or parents.get(entity.frame_id, "world") != "world":
            continue
        frame, rotation = place_in_world(transforms, entity.frame_id)
        for shape in (*entity.cubes, *entity.cylinders):
            place, turn = read_pose(shape.pose.position, shape.pose.orientation)
            x, y, z = np.abs(((points - frame) @ rotation - place) @ turn).T
            size = shape.size
            is_box = shape.DESCRIPTOR.name == "CubePrimitive"
            beyond = [x - size.x / 2, y - size.y / 2] if is_box else [np.hypot(x, y) - size.x / 2]
            outside = np.stack([*beyond, z - size.z / 2])
            found.append(np.hypot.reduce(np.maximum(outside, 0)) + np.abs(np.minimum(outside.max(axis=0), 0)))
    nearest: FloatArray = np.array(found).min(axis=0)
    return nearest


@pytest.mark.parametrize("latency", [0.0, 0.2, 0.3, 0.0777, 0.399, 1.5, 2.0])
def test_each_scan_lies_on_the_walls_at_its_own_instant(tmp_path: Path, latency: float) -> None:
    recording = record(tmp_path, f"task.laser.latency={latency}")
    (scene,) = (message.content for message in recording.messages("/scene"))
    by_time = {message.time: message.content.transforms for message in recording.messages("/tf")}
    assert all(time == nanoseconds(each.timestamp) for time, transforms in by_time.items() for each in transforms)
    scans = [*recording.messages("/scan")]
    effective = round(latency / 0.005) * 5_000_000
    for number, (message, points) in enumerate(zip(scans, read_scans(recording), strict=True)):
        stamp = nanoseconds(message.content.timestamp)
        assert (message.time, stamp) == (200_000_000 * number, max(0, 200_000_000 * number - effective))
        assert distances(points, scene, by_time[stamp]).max() < 0.004
    times = [message.time for message in recording.messages()]
    assert times == sorted(times)


def test_a_beam_without_a_return_is_infinite_and_no_hit(tmp_path: Path) -> None:
    recording = record(tmp_path, "task.laser.dropout=0.3", "task.laser.latency=0.25")
    (scene,) = (message.content for message in recording.messages("/scene"))
    by_time = {message.time: message.content.transforms for message in recording.messages("/tf")}
    scans = [message.content for message in recording.messages("/scan")]
    ranges = np.array([scan.ranges for scan in scans])
    assert 0.3 < np.isinf(ranges).mean() < 0.6
    assert ranges[np.isfinite(ranges)].max() < 5.6
    for scan, points in zip(scans, read_scans(recording), strict=True):
        assert len(points) == np.isfinite(scan.ranges).sum()
        assert distances(points, scene, by_time[nanoseconds(scan.timestamp)]).max() < 0.004


def test_a_command_is_stamped_when_it_is_given_and_odometry_when_it_is_measured(tmp_path: Path) -> None:
    recording = record(tmp_path)
    commands = [(message.time, message.content) for message in recording.messages("/cmd_vel")]
    steps = recording.steps()
    assert commands == [(200_000_000 * number, step["action"]) for number, step in enumerate(steps)]
    odometry = [message.content for message in recording.messages("/odom")]
    assert [nanoseconds(each.timestamp) for each in odometry] == [200_000_000 * n for n in range(len(steps) + 1)]
    assert {(each.frame_id, each.body_frame_id) for each in odometry} == {("world", "base")}
    for each, transforms in zip(odometry, recording.messages("/tf"), strict=True):
        (base,) = (each for each in transforms.content.transforms if each.child_frame_id == "base")
        assert str(each.pose.position) == str(base.translation)
        assert str(each.pose.orientation) == str(base.rotation)
    places = np.array([(each.pose.position.x, each.pose.position.y) for each in odometry])
    yaws = np.array([2 * np.arctan2(each.pose.orientation.z, each.pose.orientation.w) for each in odometry])
    velocities = np.array([(each.linear_velocity.x, each.angular_velocity.z) for each in odometry])
    turned, middle = np.diff(np.unwrap(yaws)), np.unwrap(yaws)[:-1] + np.diff(np.unwrap(yaws)) / 2
    moved = (np.diff(places, axis=0) * np.stack([np.cos(middle), np.sin(middle)], axis=1)).sum(axis=1)
    for driven, measured in ((moved, velocities[:, 0]), (turned, velocities[:, 1])):
        slope = np.polyfit((measured[1:] + measured[:-1]) / 2, driven, 1)[0]
        assert slope == pytest.approx(0.2, rel=0.25)
