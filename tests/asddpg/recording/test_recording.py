"""Contents of a recording, and that recording disturbs no training."""

import itertools
import math
import resource
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest
import yaml
from foxglove.messages import (
    CompressedImage,
    CompressedVideo,
    FrameTransform,
    FrameTransforms,
    LaserScan,
    Log,
    Odometry,
    PoseInFrame,
    SceneUpdate,
    Timestamp,
    Vector3,
)
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap.records import Schema
from mcap.writer import Writer
from mcap_protobuf.decoder import DecoderFactory

from asddpg import evaluate, train
from asddpg.build import controller_for, make_environment, navigation_env
from asddpg.command_line import train_config
from asddpg.episodes.drivers import FixedDriver, controller_alone
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Decision, Driver, Observation, Step
from asddpg.errors import UserError
from asddpg.recording.files.reading import Recording, open_recording
from asddpg.recording.messages.channels import compact
from asddpg.recording.messages.path_message import DRIVER_COLOURS, OTHER_COLOUR, PATH_HEIGHT, PATH_WIDTH, PathMessage
from asddpg.recording.messages.step_message import read_reward
from asddpg.recording.messages.template import MessageTemplate
from asddpg.recording.messages.topics import CMD_VEL_SCHEMA, OUTCOME_SCHEMA, STEP_SCHEMA
from asddpg.recording.recorder import BATCH_STEPS, Provenance, Recorder, Selection, every_nth
from tasks.scene.frames import BodyFrames
from tasks.scene.shapes import Shape, scene_parts
from tests.conftest import ROOT, TINY

PROVENANCE = Provenance("seed: 1\n", {"task": "nav_complex"})
Notify = Callable[[str], None]


def environment_of(task: str = "nav_complex") -> gymnasium.Env:
    config = train_config([f"task={task}"])
    environment = make_environment(config.task, config.reward)
    environment.reset(seed=101)
    return environment


def controller_of(environment: gymnasium.Env) -> FixedDriver:
    return controller_alone(controller_for(environment, train_config([]).controller))


def recorder_for(
    folder: Path, environment: gymnasium.Env, selection: Selection | None = None, notify: Notify = print
) -> Recorder:
    return Recorder(folder, navigation_env(environment), PROVENANCE, selection or Selection(every_nth(1)), notify)


def recorded(folder: Path, task: str = "nav_complex", episodes: int = 1) -> list[Path]:
    environment = environment_of(task)
    recorder = recorder_for(folder, environment)
    for _ in range(episodes):
        run_episode(environment, controller_of(environment), (recorder,))
    return sorted(folder.iterdir())


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    (path,) = recorded(tmp_path_factory.mktemp("recorded"), "nav_gazebo")
    return open_recording(path)


# Contents ---------------------------------------------------------------------------------------------------------


def test_every_topic_is_there_in_the_order_of_simulated_time(recording: Recording) -> None:
    counts = Counter(message.topic for message in recording.messages())
    steps = recording.outcome()["steps"]
    assert steps > 5
    assert counts["/step"] == counts["/cmd_vel"] == steps
    assert counts["/tf"] == counts["/scan"] == counts["/odom"] == steps + 1
    assert counts["/scene"] == counts["/goal"] == 1
    assert counts["/outcome"] == 2
    assert counts["/log"] >= 2
    assert counts["/path"] > steps / 2
    assert [message.time for message in recording.messages("/tf")] == [200_000_000 * step for step in range(steps + 1)]
    times = [message.time for message in recording.messages()]
    assert times == sorted(times)


def test_frames_hang_together(recording: Recording) -> None:
    for message in recording.messages("/tf"):
        parents = {each.child_frame_id: each.parent_frame_id for each in message.content.transforms}
        assert parents["laser"] == parents["left_wheel"] == parents["right_wheel"] == "base"
        assert parents["base"] == parents["keg"] == "world"
        assert parents["caster"] == "caster_swivel"
        assert set(parents.values()) <= {"world", *parents}


def test_the_scene_shows_room_robot_goal_and_movables_in_known_frames(recording: Recording) -> None:
    (scene,) = recording.messages("/scene")
    frames = {entity.id: entity.frame_id for entity in scene.content.entities}
    assert frames["base"] == "base"
    assert frames["goal"] == "goal"
    assert frames["keg"] == "keg"
    assert frames["world"] == "world"
    assert sum(len(entity.cubes) for entity in scene.content.entities) > 50
    assert all(entity.frame_locked for entity in scene.content.entities)
    shapes = [shape for entity in scene.content.entities for shape in entity.cylinders]
    assert all(shape.top_scale == shape.bottom_scale == 1 for shape in shapes)


def test_a_step_holds_decision_values_and_reward(tmp_path: Path) -> None:
    environment = environment_of()
    third = np.float32(1 / 3)
    action = np.array([third, -third], dtype=np.float32)
    decision = Decision(
        action, Driver.POLICY, action, action, noise=action, q_policy=0.25, q_controller=float("nan"), value=1.5
    )
    recorder = recorder_for(tmp_path, environment)
    run_episode(environment, FixedDriver(lambda _: decision), (recorder,), max_steps=3)
    steps = open_recording(next(tmp_path.iterdir())).steps()
    assert [step["step"] for step in steps] == [0, 1, 2]
    first = steps[0]
    assert np.float32(first["action"]["v"]) == third
    assert first["driver"] == "policy"
    assert (first["q_policy"], first["value"]) == (0.25, 1.5)
    assert "q_controller" not in first
    assert first["noise"]["omega"] == pytest.approx(-1 / 3, abs=1e-5)
    assert sum(first["terms"].values()) == pytest.approx(first["reward"])


def test_a_long_path_is_encoded_as_foxglove_does() -> None:
    path = PathMessage((0.0, 0.0))
    drivers = ["policy"] * 150 + ["controller"] + ["policy"] * 3 + ["somebody"]
    for number, driver in enumerate(drivers):
        path.extend(driver, (number / 8, -number / 16))
    (entity,) = decoder_for(SceneUpdate)(path.encode()).entities
    assert (entity.id, entity.frame_id) == ("path", "world")
    assert [len(line.points) for line in entity.lines] == [151, 2, 4, 2]
    for before, line in itertools.pairwise(entity.lines):
        assert before.points[-1] == line.points[0]
    colours = [(line.color.r, line.color.g, line.color.b) for line in entity.lines]
    assert colours == [
        DRIVER_COLOURS.get(name, OTHER_COLOUR) for name in ("policy", "controller", "policy", "somebody")
    ]
    assert {(line.thickness, line.pose.orientation.w, line.color.a) for line in entity.lines} == {(PATH_WIDTH, 1, 1)}
    last = entity.lines[-1].points[-1]
    assert (last.x, last.y, last.z) == (154 / 8, -154 / 16, PATH_HEIGHT)


def test_the_path_ends_under_the_robot(recording: Recording) -> None:
    """Its radius is 0.27 m: where the line ends cannot be seen."""
    ends = {message.time: message.content.entities[0].lines[-1].points[-1] for message in recording.messages("/path")}
    end = ends[0]
    for message in recording.messages("/odom"):
        end = ends.get(message.time, end)
        place = message.content.pose.position
        assert math.dist((end.x, end.y), (place.x, place.y)) < 0.15


def test_a_long_path_is_published_less_often(tmp_path: Path) -> None:
    """Each time whole: every other step would make as many points as steps squared, over four."""
    config = train_config(["task=nav_complex", "task.min_linear_velocity=0", "task.time_limit_steps=1000"])
    environment = make_environment(config.task, config.reward)
    environment.reset(seed=101)
    still = Decision(np.zeros(2, dtype=np.float32), Driver.POLICY)
    run_episode(environment, FixedDriver(lambda _: still), (recorder_for(tmp_path, environment),), max_steps=1000)
    paths = [message.content for message in open_recording(next(tmp_path.iterdir())).messages("/path")]
    points = sum(len(line.points) for path in paths for line in path.entities[0].lines)
    assert points < 0.5 * 1000**2 / 4
    assert len(paths[-1].entities[0].lines[0].points) == 1001


def test_json_is_described_as_foxglove_reads_it() -> None:
    """Its viewer takes one type a field and wants to know each object's properties, or shows nothing of the topic."""
    for schema in (STEP_SCHEMA, OUTCOME_SCHEMA, CMD_VEL_SCHEMA):
        waiting = [schema]
        for part in waiting:
            assert part["type"] in ("object", "number", "string")
            assert (part["type"] == "object") == ("properties" in part)
            waiting += part.get("properties", {}).values()
        assert len(waiting) > 2


def test_a_recording_holds_configuration_and_provenance(tmp_path: Path) -> None:
    train.main(["task=nav_simple", *TINY, "total_steps=60", "record.every=1", f"run_dir={tmp_path / 'run'}"])
    for path in sorted((tmp_path / "run" / "episodes").iterdir()):
        recording = open_recording(path)
        assert yaml.safe_load(recording.config) == yaml.safe_load((tmp_path / "run" / "config.yaml").read_text())
        assert {"mujoco", "model_hash", "seed", "task", "episode", "step"} <= set(recording.facts)


def test_recording_changes_nothing_that_is_learned(tmp_path: Path) -> None:
    arguments = ["task=nav_complex", *TINY, "agent.learning_starts=50"]
    train.main([*arguments, "record.every=1", f"run_dir={tmp_path / 'with'}"])
    train.main([*arguments, "record.every=0", f"run_dir={tmp_path / 'without'}"])
    assert not (tmp_path / "without" / "episodes").exists()
    for name in ("metrics.csv", "validation.csv"):
        assert (tmp_path / "with" / name).read_bytes() == (tmp_path / "without" / name).read_bytes()


# Selection --------------------------------------------------------------------------------------------------------


def test_every_so_many_episodes_are_recorded_and_the_oldest_go(tmp_path: Path) -> None:
    environment = environment_of()
    recorder = recorder_for(tmp_path, environment, Selection(every_nth(2), keep=2))
    for _ in range(7):
        run_episode(environment, controller_of(environment), (recorder,))
    assert [path.name.split("_")[1] for path in sorted(tmp_path.iterdir())] == ["00005", "00007"]


def test_only_chosen_outcomes_are_kept(tmp_path: Path) -> None:
    environment = environment_of()
    recorder = recorder_for(tmp_path, environment, Selection(every_nth(1), outcomes=("timeout",)))
    run_episode(environment, controller_of(environment), (recorder,))
    assert list(tmp_path.iterdir()) == []
    assert recorder.files == 0


def test_an_evaluation_records_chosen_episodes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    evaluate.main(["agent=controller", "task=nav_empty", "episodes=4", "record.only=[2,4]"])
    assert "2 episodes recorded in evaluated_episodes" in capsys.readouterr().out
    names = sorted(path.name for path in (tmp_path / "evaluated_episodes").iterdir())
    assert [name.split("_")[1:] for name in names] == [["00002", "reached.mcap"], ["00004", "reached.mcap"]]
    facts = open_recording(tmp_path / "evaluated_episodes" / names[0]).facts
    assert facts["pairs"] == "4 stored test pairs"
    assert facts["driver"] == "controller"


# Errors -----------------------------------------------------------------------------------------------------------


def test_an_interrupted_episode_is_completed_as_cut(tmp_path: Path) -> None:
    environment = environment_of()
    recorder = recorder_for(tmp_path, environment)

    def stop_after(steps: int) -> Callable[[Observation], Decision]:
        count = iter(range(steps))

        def decide(_: Observation) -> Decision:
            if next(count, None) is None:
                raise KeyboardInterrupt
            return Decision(np.zeros(2, dtype=np.float32), Driver.POLICY)

        return decide

    with pytest.raises(KeyboardInterrupt):
        run_episode(environment, FixedDriver(stop_after(13)), (recorder,))
    recorder.close()
    (path,) = tmp_path.iterdir()
    assert path.name.endswith("_cut.mcap")
    assert len(open_recording(path).steps()) == open_recording(path).outcome()["steps"] == 13


def test_a_recording_interrupted_after_a_non_finite_reward_is_completed_too(tmp_path: Path) -> None:
    environment = environment_of()
    recorder = recorder_for(tmp_path, environment)
    observation, info = environment.reset(options={"start": (0.0, 0.0, 0.0), "goal": (3.0, -2.5)})
    recorder.begin_episode(observation, info)
    decision = Decision(np.zeros(2, dtype=np.float32), Driver.CONTROLLER)
    for reward in (0.5, float("nan")):
        observation, _, _, _, info = environment.step(decision.action)
        info = info | {"reward_terms": {"progress": 0.0, "time": reward}}
        recorder.step(Step(observation, decision, reward, observation, False, False, info), {})
    recorder.close()
    recording = open_recording(next(tmp_path.iterdir()))
    outcome, (whole, broken) = recording.outcome(), recording.steps()
    assert (whole["reward"], whole["terms"]) == (0.5, {"progress": 0.0, "time": 0.5})
    assert "reward" not in broken
    assert broken["terms"] == {"progress": 0.0}
    assert math.isnan(read_reward(broken))
    assert (outcome["outcome"], outcome["steps"], outcome["controller_share"]) == ("cut", 2, 1.0)
    assert "total_reward" not in outcome


def test_a_part_holds_all_but_the_last_steps(tmp_path: Path) -> None:
    environment = environment_of()
    recorder = recorder_for(tmp_path, environment)
    action = np.zeros(2, dtype=np.float32)
    found = []

    def decide(_: Observation) -> Decision:
        found.append(sum(len(open_recording(part).steps()) for part in tmp_path.iterdir()))
        return Decision(action, Driver.POLICY)

    run_episode(environment, FixedDriver(decide), (recorder,), max_steps=3 * BATCH_STEPS)
    assert all(step - BATCH_STEPS < count <= step for step, count in enumerate(found))


def test_a_folder_that_cannot_be_written_stops_no_training(tmp_path: Path) -> None:
    (tmp_path / "episodes").write_text("in the way")
    environment = environment_of()
    said: list[str] = []
    recorder = recorder_for(tmp_path / "episodes", environment, notify=said.append)
    for _ in range(3):
        assert run_episode(environment, controller_of(environment), (recorder,)).steps > 0
    (sentence,) = said
    assert "episode 1 is not recorded" in sentence


@pytest.mark.parametrize("steps", [30, 5])  # the part cannot be written; the complete file
def test_a_full_disk_stops_no_training_and_leaves_no_file(tmp_path: Path, steps: int) -> None:
    environment = environment_of()
    sentences: list[str] = []
    recorder = recorder_for(tmp_path, environment, notify=sentences.append)
    decision = Decision(np.zeros(2, dtype=np.float32), Driver.POLICY)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, limits[1]))
    try:
        for _ in range(2):
            run_episode(environment, FixedDriver(lambda _: decision), (recorder,), max_steps=steps)
            assert list(tmp_path.iterdir()) == []
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    (sentence,) = sentences
    assert sentence.startswith("episode 1 is not recorded")
    assert "File too large" in sentence
    run_episode(environment, FixedDriver(lambda _: decision), (recorder,), max_steps=steps)
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    "change",
    [
        lambda whole: whole[:3000],
        lambda _: b"",
        lambda _: b"a text\n" * 100,
        lambda whole: whole[:9000] + bytes(40) + whole[9040:],
    ],
)
def test_a_damaged_recording_is_refused_in_a_sentence(
    tmp_path: Path, recording: Recording, change: Callable[[bytes], bytes]
) -> None:
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(change(recording.path.read_bytes()))
    with pytest.raises(UserError, match="is damaged or not a recording"):
        list(open_recording(damaged).messages())


def test_a_recording_of_another_program_is_refused_in_a_sentence(tmp_path: Path) -> None:
    with (tmp_path / "other.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(UserError, match="a recording of another program"):
        open_recording(tmp_path / "other.mcap")
    with pytest.raises(UserError, match="cannot be read: No such file"):
        open_recording(tmp_path / "missing.mcap")


# Size -----------------------------------------------------------------------------------------------------------------


def test_size_on_disk(recording: Recording) -> None:
    """On average 18 kB and 450 bytes a step in nav_complex (tools.bench); this room has more frames and shapes."""
    steps = recording.outcome()["steps"]
    assert recording.path.stat().st_size < 25_000 + 450 * steps


# Parts --------------------------------------------------------------------------------------------------------------


def test_a_filled_template_equals_the_message_of_its_numbers() -> None:
    def make(stamp: Timestamp, numbers: Sequence[float]) -> FrameTransforms:
        vectors = [Vector3(x=x, y=y, z=z) for x, y, z in (numbers[:3], numbers[3:])]
        return FrameTransforms(transforms=[FrameTransform(timestamp=stamp, translation=each) for each in vectors])

    template, decode = MessageTemplate(make, 6), decoder_for(FrameTransforms)
    for time_ns in (0, 200_000_000, 4_000_123_456_789):
        numbers = [0.0, -1.5, 1e-3, 2.0, 0.0, 1e9]  # protobuf leaves zeros out
        found = decode(template.fill(time_ns, numbers)).transforms
        for each, expected in zip(found, (numbers[:3], numbers[3:]), strict=True):
            assert [each.translation.x, each.translation.y, each.translation.z] == expected
            assert each.timestamp.seconds * 10**9 + each.timestamp.nanos == time_ns


def test_compact_schemas_describe_the_same_messages() -> None:
    for kind in (FrameTransforms, LaserScan, Odometry, PoseInFrame, SceneUpdate, Log, CompressedImage, CompressedVideo):
        schema = kind.get_schema()
        small = compact(schema)
        assert (small.name, small.encoding) == (schema.name, schema.encoding)
        assert descriptors_in(small.data) == descriptors_in(schema.data)
        assert len(small.data) < 0.75 * len(schema.data)
        assert DecoderFactory().decoder_for("protobuf", Schema(1, small.data, small.encoding, small.name)) is not None


def descriptors_in(schema: bytes) -> dict[str, bytes]:
    """Descriptors of messages and enumerations by their full names."""
    files = FileDescriptorSet.FromString(schema).file
    return {
        f"{file.package}.{each.name}": each.SerializeToString()
        for file in files
        for each in (*file.message_type, *file.enum_type)
    }


def decoder_for(kind: Any) -> Callable[[bytes], Any]:
    schema = kind.get_schema()
    decode = DecoderFactory().decoder_for("protobuf", Schema(1, schema.data, schema.encoding, schema.name))
    assert decode is not None
    return decode


def test_relative_frames_compose_to_the_world_s() -> None:
    environment = environment_of("nav_gazebo")
    environment.reset(options={"start": (-2.5, -0.5, 0.3), "goal": (2.0, 2.0)})
    for _ in range(4):
        environment.step(np.array([0.3, 0.8], dtype=np.float32))
    physics = navigation_env(environment).physics
    frames = BodyFrames.from_model(physics.model.ptr)
    data = physics.data.ptr
    (places,) = frames.relative([data.xpos.tobytes() + data.xquat.tobytes() + data.xmat.tobytes()])
    in_world: dict[str, tuple[Any, Any]] = {"world": (np.zeros(3), np.eye(3))}
    for frame, place in zip(frames.frames, places, strict=True):
        position, turn = in_world[frame.parent]
        own, (x, y, z, w) = np.empty(9), place[3:]
        mujoco.mju_quat2Mat(own, np.array([w, x, y, z]))
        in_world[frame.name] = position + turn @ place[:3], turn @ own.reshape(3, 3)
        body = physics.model.ptr.body(frame.name).id
        assert in_world[frame.name][0] == pytest.approx(physics.data.ptr.xpos[body], abs=1e-9)
        assert in_world[frame.name][1].ravel() == pytest.approx(physics.data.ptr.xmat[body], abs=1e-9)


def test_any_scene_gives_its_parts() -> None:
    model = mujoco.MjModel.from_xml_string(
        """
        <mujoco>
          <asset>
            <mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/>
            <material name="red" rgba="1 0 0 1"/>
          </asset>
          <worldbody>
            <geom name="floor" type="plane" size="0 0 1"/>
            <body name="shelf" pos="1 0 0"><geom type="box" size="0.1 0.2 0.3" rgba="0 1 0 1"/></body>
            <body name="ball" pos="0 0 1"><freejoint/><geom type="sphere" size="0.5" material="red"/></body>
            <body pos="0 2 1"><freejoint/><geom type="capsule" size="0.1 0.4"/></body>
            <body name="wedge"><freejoint/><geom type="mesh" mesh="wedge"/><geom size="1" group="3"/></body>
            <body name="egg">
              <freejoint/>
              <geom type="ellipsoid" size="0.1 0.2 0.3"/>
              <geom size="1" rgba="0 0 0 0"/>
            </body>
          </worldbody>
        </mujoco>
        """
    )
    parts = scene_parts(model)
    by_owner = {owner: [part for part in parts if part.owner == owner] for owner in {part.owner for part in parts}}
    (shelf,), (ball,), (wedge,), (egg,) = (by_owner[name] for name in ("shelf", "ball", "wedge", "egg"))
    assert (shelf.frame, shelf.position.tolist()) == ("world", [1, 0, 0])
    assert shelf.size == pytest.approx([0.2, 0.4, 0.6])
    assert (ball.frame, ball.rgba.tolist()) == ("ball", [1, 0, 0, 1])
    assert [part.shape for part in by_owner["body_3"]] == [Shape.CYLINDER, Shape.ELLIPSOID, Shape.ELLIPSOID]
    ends = sorted(part.position[2] for part in by_owner["body_3"])
    assert ends == pytest.approx([-0.4, 0, 0.4])
    assert wedge.faces is not None
    assert wedge.vertices is not None
    assert wedge.vertices.shape == (4, 3)
    assert egg.size == pytest.approx([0.2, 0.4, 0.6])


@pytest.mark.slow
@pytest.mark.parametrize(("stop", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_training_that_is_stopped_completes_its_recording(tmp_path: Path, stop: signal.Signals, status: int) -> None:
    folder = tmp_path / "run"
    arguments = ["task=nav_empty", *TINY, "total_steps=100000", "agent.learning_starts=90000", "validation.every=0"]
    command = [sys.executable, "-m", "asddpg.train", *arguments, "record.every=1", f"run_dir={folder}"]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while len(list(folder.glob("episodes/*.mcap"))) < 3 and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(stop)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == status
    assert "Traceback" not in errors
    assert not list(folder.glob("episodes/*.part"))
    *finished, last = sorted((folder / "episodes").iterdir())
    assert finished
    for path in (*finished, last):
        recording = open_recording(path)
        assert len(recording.steps()) == recording.outcome()["steps"]
    assert (folder / "checkpoints" / "last.safetensors").is_file()
