"""The layout for Foxglove shows topics and fields that a recording has."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asddpg import mission as missions
from asddpg.build import make_environment, navigation_env
from asddpg.command_line import train_config
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Decision, Driver
from asddpg.recording.files.reading import open_recording
from asddpg.recording.how_to_open import LAYOUT
from asddpg.recording.live.listener import GOAL_TOPICS
from asddpg.recording.messages.topics import AMCL_POSE, CAMERA, MAP, PARTICLES, PLAN
from asddpg.recording.recorder import Provenance, Recorder, Selection, every_nth
from tasks.scene.loading import TASK_CAMERAS

PANELS = {"3D", "Image", "Plot", "StateTransitions", "Gauge", "Indicator", "RosOut", "Parameters", "Publish", "Tab"}
# What a panel of each kind can draw.
NUMBERS, TEXTS = {"Plot", "Gauge"}, {"StateTransitions", "Indicator"}
NAVIGATION = (MAP, PLAN, PARTICLES, AMCL_POSE)  # in recordings of missions
CAMERAS = {f"{CAMERA}{name}" for name in TASK_CAMERAS}  # in recordings that were made with cameras

Messages = dict[str, list[Any]]


@pytest.fixture(scope="module")
def layout() -> dict[str, Any]:
    content: dict[str, Any] = json.loads(LAYOUT.read_text(encoding="utf-8"))
    return content


@pytest.fixture(scope="module")
def messages(tmp_path_factory: pytest.TempPathFactory) -> Messages:
    """Of a recorded episode, by topic."""
    config = train_config([])
    environment = make_environment(config.task, config.reward)
    environment.reset(seed=1)
    action = np.array([0.2, 0.1], dtype=np.float32)
    decision = Decision(action, Driver.POLICY, action, action, action, q_policy=1.0, q_controller=0.5, value=0.7)
    folder = tmp_path_factory.mktemp("recorded")
    recorder = Recorder(folder, navigation_env(environment), Provenance(""), Selection(every_nth(1)), print)
    run_episode(environment, FixedDriver(lambda _: decision), (recorder,), max_steps=3)
    return read_messages(folder)


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Messages:
    """Of a mission of three steps, by topic."""
    folder = tmp_path_factory.mktemp("mission")
    arguments = ["agent=move_base", "task=nav_empty", "start=[0,0,0]", "targets=[3,0]", "patience=0.6"]
    missions.main([*arguments, f"out={folder}"])
    return read_messages(folder / "missions/episodes")


def read_messages(folder: Path) -> Messages:
    """Of the only recording in a folder."""
    (path,) = folder.iterdir()
    found: Messages = {}
    for message in open_recording(path).messages():
        found.setdefault(message.topic, []).append(message.content)
    return found


def resolve(path: str, messages: Messages) -> Any:
    """The value that a message path of Foxglove's names, in the last message of its topic.

    Raises:
        LookupError: there is no such topic, field or element.
    """
    match = re.fullmatch(r"(/[\w/]+)((?:\.\w+|\[\d+\])*)((?:\.@\w+)*)", path)
    if match is None:
        raise LookupError(f"{path} is no message path")
    topic, fields, _ = match.groups()
    value = messages[topic][-1]
    for name, index in re.findall(r"\.(\w+)|\[(\d+)\]", fields):
        if index:
            value = value[int(index)]
        elif isinstance(value, dict):
            value = value[name]
        elif name in value.DESCRIPTOR.fields_by_name:
            value = getattr(value, name)
        else:
            raise LookupError(f"{path}: there is no {name}")
    return value


def panels_in(tree: Any, config: dict[str, Any]) -> Iterator[str]:
    """Ids of the panels in a tree, and in the tabs in it."""
    if isinstance(tree, str):
        yield tree
        for tab in config.get(tree, {}).get("tabs", ()):
            yield from panels_in(tab["layout"], config)
    else:
        assert set(tree) == {"direction", "first", "second", "splitPercentage"}
        assert tree["direction"] in ("row", "column")
        assert 0 < tree["splitPercentage"] < 100
        yield from panels_in(tree["first"], config)
        yield from panels_in(tree["second"], config)


def paths_in(layout: dict[str, Any]) -> list[tuple[str, str]]:
    """Kind of panel and message path, of all there are."""
    found = []
    for panel, config in layout["configById"].items():
        kind = panel.partition("!")[0]
        values = [each["value"] for each in config.get("paths", ())]
        values += [config["path"]] if "path" in config else []
        found += [(kind, value) for value in values]
    return found


def test_each_panel_has_its_place_and_its_settings(layout: dict[str, Any]) -> None:
    placed = list(panels_in(layout["layout"], layout["configById"]))
    assert sorted(placed) == sorted(layout["configById"])
    assert {panel.partition("!")[0] for panel in placed} == PANELS


def test_it_has_the_form_of_an_export(layout: dict[str, Any]) -> None:
    assert set(layout) == {"configById", "globalVariables", "userNodes", "playbackConfig", "layout"}
    for config in layout["configById"].values():
        assert config["foxglovePanelTitle"] == config["lichtblickPanelTitle"] != ""


def test_each_message_path_is_in_a_recording(layout: dict[str, Any], messages: Messages) -> None:
    paths = paths_in(layout)
    assert len(paths) > 10
    for kind, path in paths:
        value = resolve(path, messages)
        assert isinstance(value, (int, float) if kind in NUMBERS else str), path
        assert kind in NUMBERS | TEXTS


def test_each_topic_is_in_a_recording(layout: dict[str, Any], messages: Messages, mission: Messages) -> None:
    panels = layout["configById"]
    topics_shown = panels["3D!robot"]["topics"]
    assert all(settings["visible"] for settings in topics_shown.values())
    assert {"/scan", "/scene", "/path", *NAVIGATION} == set(topics_shown)  # the goal is in the scene
    assert set(topics_shown) - set(NAVIGATION) <= set(messages)
    assert not set(NAVIGATION) & set(messages), "a policy has neither map nor plan"
    assert set(topics_shown) <= set(mission)
    assert panels["RosOut!log"]["topicToRender"] in messages
    assert panels["Image!chase"]["imageMode"]["imageTopic"] in CAMERAS
    assert f"{CAMERA}chase" in CAMERAS


def test_the_map_is_drawn_in_the_colours_of_its_cells(layout: dict[str, Any], mission: Messages) -> None:
    settings = layout["configById"]["3D!robot"]["topics"]["/map"]
    assert settings["colorMode"] == "rgba-fields"
    fields = {field.name: field.offset for field in mission["/map"][-1].fields}
    assert {"red", "green", "blue", "alpha"} <= set(fields)
    for topic in NAVIGATION[1:]:
        assert layout["configById"]["3D!robot"]["topics"][topic]["type"] in ("line", "arrow")


def test_each_outcome_has_its_colour(layout: dict[str, Any]) -> None:
    rules = layout["configById"]["Indicator!outcome"]["rules"]
    assert [rule["rawValue"] for rule in rules] == ["running", "reached", "crashed", "timeout", "cut"]
    assert len({rule["color"] for rule in rules}) == len(rules)


def test_it_follows_a_frame_that_there_is(layout: dict[str, Any], messages: Messages) -> None:
    robot = layout["configById"]["3D!robot"]
    frames = {transform.child_frame_id for transform in messages["/tf"][-1].transforms}
    assert robot["followTf"] in frames


def test_goals_are_published_on_the_subscribed_topics(layout: dict[str, Any]) -> None:
    robot, publish = (layout["configById"][name] for name in ("3D!robot", "Publish!goal"))
    topics = {robot["publish"]["pointTopic"], robot["publish"]["poseTopic"], publish["topicName"]}
    assert topics == set(GOAL_TOPICS)
    assert set(json.loads(publish["value"])["pose"]["position"]) >= {"x", "y"}


@pytest.mark.parametrize("path", ["/nothing.x", "/step.nothing", "/odom.nothing", "/scan.ranges[400]", "step.q"])
def test_a_missing_field_does_not_resolve(messages: Messages, path: str) -> None:
    with pytest.raises(LookupError):
        resolve(path, messages)
