"""A viewer with Foxglove's WebSocket protocol, https://github.com/foxglove/ws-protocol, over a real socket."""

import base64
import contextlib
import json
import struct
import time
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, Self, TypeVar

from mcap.records import Schema
from mcap_protobuf.decoder import DecoderFactory
from websockets.sync.client import connect
from websockets.typing import Subprotocol

PATIENCE = 60.0  # s that anything may take; a test that passes waits for what happens and no longer
QUIET = 0.3  # s without a message after which no more comes; a step takes a few ms
_MESSAGE, _TIME = 1, 2  # opcodes

Found = TypeVar("Found")


class Received(NamedTuple):
    """A message, decoded."""

    topic: str
    time: int
    content: Any


class Viewer:
    """A connection and everything it received."""

    def __init__(self, port: int) -> None:
        connection = connect(
            f"ws://127.0.0.1:{port}",
            subprotocols=[Subprotocol("foxglove.sdk.v1")],
            proxy=None,
            max_size=None,
            max_queue=None,
        )
        self._open = contextlib.ExitStack()
        self._socket = self._open.enter_context(connection)
        self._topics: dict[int, str] = {}  # by subscription
        self._decoders: dict[int, Callable[[bytes], Any]] = {}
        self._published: list[str] = []
        self.channels: dict[str, dict[str, Any]] = {}
        self.messages: list[Received] = []
        self.times: list[int] = []
        self.statuses: list[str] = []
        self.parameters: dict[str, Any] = {}

    @classmethod
    def when_served(cls, port: int) -> Self:
        """Connect as soon as the port is served."""
        deadline = time.monotonic() + PATIENCE
        while True:
            try:
                return cls(port)
            except ConnectionRefusedError:
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.01)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._open.close()

    # Requests -----------------------------------------------------------------------------------------------------

    def watch(self, *topics: str) -> None:
        self.until(lambda: set(topics) <= set(self.channels))
        wanted = []
        for topic in topics:
            number = len(self._topics) + 1
            channel = self.channels[topic]
            self._topics[number], self._decoders[number] = topic, _decoder(channel)
            wanted.append({"id": number, "channelId": channel["id"]})
        self._send(op="subscribe", subscriptions=wanted)

    def ask(self) -> dict[str, Any]:
        """The parameters, as they are now."""
        self.parameters = {}
        self._send(op="getParameters", parameterNames=[], id="all")
        self.until(lambda: self.parameters)
        return self.parameters

    def follow_parameters(self, *names: str) -> None:
        self._send(op="subscribeParameterUpdates", parameterNames=names)

    def set(self, name: str, value: Any) -> None:
        """Set a parameter and wait for the answer."""
        self.parameters = {}
        self._send(op="setParameters", parameters=[{"name": name, "value": value}], id=name)
        self.until(lambda: self.parameters)

    def publish(self, topic: str, content: Any, encoding: str = "json") -> None:
        if topic not in self._published:
            self._published.append(topic)
            channel = {"id": len(self._published), "topic": topic, "encoding": encoding, "schemaName": "a place"}
            self._send(op="advertise", channels=[channel])
        data = content if isinstance(content, bytes) else json.dumps(content).encode()
        self._socket.send(struct.pack("<BI", _MESSAGE, self._published.index(topic) + 1) + data)

    # Messages -----------------------------------------------------------------------------------------------------

    def of(self, topic: str) -> list[Any]:
        return [message.content for message in self.messages if message.topic == topic]

    def next(self, topic: str, condition: Callable[[Any], object] = lambda _: True) -> Any:
        """The next message of a topic, from now on, that satisfies a condition."""
        seen = len(self.messages)

        def found() -> list[Any]:
            return [m.content for m in self.messages[seen:] if m.topic == topic and condition(m.content)]

        return self.until(found)[0]

    def status(self, part: str) -> str:
        """The status that holds a text."""
        return self.until(lambda: next((status for status in self.statuses if part in status), ""))

    def until(self, condition: Callable[[], Found]) -> Found:
        """Receive until a condition holds; returns its value."""
        deadline = time.monotonic() + PATIENCE
        while not (found := condition()):
            self._take(self._socket.recv(timeout=max(0.0, deadline - time.monotonic())))
        return found

    def settle(self) -> None:
        """Receive until nothing comes any more."""
        with contextlib.suppress(TimeoutError):
            while True:
                self._take(self._socket.recv(timeout=QUIET))

    def _send(self, **content: Any) -> None:
        self._socket.send(json.dumps(content))

    def _take(self, data: str | bytes) -> None:
        if isinstance(data, bytes):
            self._take_binary(data)
            return
        content = json.loads(data)
        if content["op"] == "advertise":
            self.channels |= {channel["topic"]: channel for channel in content["channels"]}
        elif content["op"] == "status":
            self.statuses.append(content["message"])
        elif content["op"] == "parameterValues":
            self.parameters |= {each["name"]: each["value"] for each in content["parameters"]}

    def _take_binary(self, data: bytes) -> None:
        if data[0] == _TIME:
            self.times += struct.unpack_from("<Q", data, 1)
        elif data[0] == _MESSAGE:
            subscription, at = struct.unpack_from("<IQ", data, 1)
            self.messages.append(Received(self._topics[subscription], at, self._decoders[subscription](data[13:])))


def _decoder(channel: dict[str, Any]) -> Callable[[bytes], Any]:
    if channel["encoding"] == "json":
        return json.loads
    schema = Schema(id=1, data=base64.b64decode(channel["schema"]), encoding="protobuf", name=channel["schemaName"])
    decoder = DecoderFactory().decoder_for("protobuf", schema)
    assert decoder is not None
    return decoder


def steps_of(messages: Iterable[Received]) -> list[int]:
    """Numbers of the received steps."""
    return [message.content["step"] for message in messages if message.topic == "/step"]
