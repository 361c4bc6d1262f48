"""The ROS 2 node of docs/guides/own_laser.md, with stand-ins for the libraries of ROS, drives in the simulator."""

import math
import re
import sys
from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from asddpg.deployment import load_policy
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tests.conftest import ROOT

GUIDE = ROOT / "docs" / "guides" / "own_laser.md"


class Message(SimpleNamespace):
    """Makes its fields where they are first read; a number that was not set is 0."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        value = 0.0 if name in {"x", "y", "z", "w"} else Message()
        setattr(self, name, value)
        return value


class LaserScan(Message):
    pass


class Odometry(Message):
    pass


class PointStamped(Message):
    pass


class Twist(Message):
    pass


class Node:
    """Keeps what a node subscribes to, publishes and calls by a timer."""

    def __init__(self, name: str) -> None:
        self.subscriptions: dict[str, tuple[type, Callable[[Any], None]]] = {}
        self.published: list[Any] = []

    def create_subscription(self, kind: type, topic: str, callback: Callable[[Any], None], qos: Any) -> None:
        self.subscriptions[topic] = kind, callback

    def create_publisher(self, kind: type, topic: str, qos: Any) -> Any:
        assert (kind, topic) == (Twist, "cmd_vel")
        return SimpleNamespace(publish=self.published.append)

    def create_timer(self, seconds: float, callback: Callable[[], None]) -> None:
        self.seconds, self.tick = seconds, callback

    def receive(self, topic: str, message: Any) -> None:
        kind, callback = self.subscriptions[topic]
        assert type(message) is kind
        callback(message)


@pytest.fixture
def node(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The guide's node, which is left to us where it would be spun."""
    spun: list[Any] = []
    modules: dict[str, dict[str, Any]] = {
        "rclpy": {"init": lambda: None, "spin": spun.append},
        "rclpy.node": {"Node": Node},
        "rclpy.qos": {"qos_profile_sensor_data": None},
        "geometry_msgs.msg": {"PointStamped": PointStamped, "Twist": Twist},
        "nav_msgs.msg": {"Odometry": Odometry},
        "sensor_msgs.msg": {"LaserScan": LaserScan},
    }
    for name in ("geometry_msgs", "nav_msgs", "sensor_msgs", *modules):
        module = ModuleType(name)
        vars(module).update(modules.get(name, {}))
        monkeypatch.setitem(sys.modules, name, module)
    (code,) = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(code, str(GUIDE), "exec"), {})
    return spun[0]


def test_the_guides_node_drives_to_a_goal_as_the_policy_does_and_stops_there(node: Any) -> None:
    environment = NavigationEnv("nav_simple", config={"goal_radius": 0.0, "laser": {"num_beams": 481}})
    environment.reset(seed=0, options={"start": (-2.5, -3.0, 0.4), "goal": (1.0, 3.0)})
    policy, physics = load_policy("pretrained:nav_complex"), environment.physics
    assert node.seconds == policy.control_timestep
    node.tick()  # nothing has arrived
    node.receive("goal", PointStamped(point=Message(x=1.0, y=3.0)))
    for _ in range(120):
        ranges, readings = physics.ranges(), environment.task.readings
        ranges[ranges >= physics.max_range] = math.inf
        scan = LaserScan(ranges=ranges, range_max=5.6, angle_min=math.radians(-120), angle_increment=math.radians(0.5))
        half = readings.pose.yaw / 2
        pose = Message(
            position=Message(x=readings.pose.x, y=readings.pose.y),
            orientation=Message(z=math.sin(half), w=math.cos(half)),
        )
        motion = Message(linear=Message(x=readings.velocity.linear), angular=Message(z=readings.velocity.angular))
        node.receive("scan", scan)
        node.receive("odom", Odometry(pose=Message(pose=pose), twist=Message(twist=motion)))
        node.tick()
        command = node.published[-1]
        given = command.linear.x, command.angular.z
        if readings.goal_distance <= 0.3:
            assert given == (0.0, 0.0)
            break
        angles = np.radians(np.linspace(-120, 120, 481))
        expected = policy.act(ranges, angles, *readings.velocity, readings.goal_in_robot_frame)
        assert given == pytest.approx(expected, abs=1e-6)
        environment.step(np.array(given))
        assert not physics.crashed()
    else:
        raise AssertionError("it did not arrive")
    node.tick()
    assert node.published[-1] is command  # without a goal it is silent
