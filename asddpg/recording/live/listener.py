"""Hears what the viewers of a live view ask for; Foxglove's server calls it from threads of its own."""

from collections.abc import Callable

import orjson
from foxglove.websocket import ChannelView, Client, ClientChannel, Parameter, ServerListener

from asddpg.errors import UserError
from asddpg.recording.live.controls import LiveControls, goal_in

# Where Foxglove's 3D panel publishes a click on the floor, by its defaults, and ROS 2's name of the same.
GOAL_TOPICS = ("/clicked_point", "/move_base_simple/goal", "/goal_pose")


class LiveListener(ServerListener):
    """Who watches, and what they want changed."""

    def __init__(self, controls: LiveControls, refuse: Callable[[str], None]) -> None:
        """Pass wishes on to the controls; `refuse` tells the viewers of one that is not granted."""
        self._controls, self._refuse = controls, refuse
        self._watching: set[tuple[int, int]] = set()  # client and channel
        self._has_newcomer = False
        self._topics: dict[tuple[int, int], ClientChannel] = {}

    @property
    def is_watched(self) -> bool:
        """Whether anybody has subscribed to anything."""
        return bool(self._watching)

    def take_newcomer(self) -> bool:
        """Whether somebody has subscribed to something since this was last asked."""
        if not self._has_newcomer:
            return False  # and nothing is written: somebody might come at this very moment
        self._has_newcomer = False
        return True

    # Subscriptions ------------------------------------------------------------------------------------------------

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """Somebody watches a channel from now on."""
        self._watching.add((client.id, channel.id))
        self._has_newcomer = True
        self._controls.woken.set()

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        """No more; also called when a viewer is gone."""
        self._watching.discard((client.id, channel.id))
        self._controls.woken.set()

    # Parameters ---------------------------------------------------------------------------------------------------

    def on_get_parameters(
        self, client: Client, param_names: list[str], request_id: str | None = None
    ) -> list[Parameter]:
        """Those asked for, or all."""
        return [each for each in self.parameters() if not param_names or each.name in param_names]

    def on_set_parameters(
        self, client: Client, parameters: list[Parameter], request_id: str | None = None
    ) -> list[Parameter]:
        """Set them; one that is refused keeps its value."""
        for parameter in parameters:
            self._try(lambda each=parameter: self._controls.set(each.name, each.get_value()))  # type: ignore[misc]
        return self.parameters()

    def parameters(self) -> list[Parameter]:
        """All, as they are."""
        return [Parameter(name, value=value) for name, value in self._controls.values().items()]

    # Goals --------------------------------------------------------------------------------------------------------

    def on_client_advertise(self, client: Client, channel: ClientChannel) -> None:
        """A viewer is going to publish."""
        self._topics[client.id, channel.id] = channel

    def on_client_unadvertise(self, client: Client, client_channel_id: int) -> None:
        """No more."""
        self._topics.pop((client.id, client_channel_id), None)

    def on_message_data(self, client: Client, client_channel_id: int, data: bytes) -> None:
        """A viewer has published: a goal."""
        self._try(lambda: self._hear(self._topics[client.id, client_channel_id], data))

    def _hear(self, channel: ClientChannel, data: bytes) -> None:
        if channel.topic not in GOAL_TOPICS:
            raise UserError(f"nobody listens to {channel.topic}; a goal is heard on {', '.join(GOAL_TOPICS)}")
        if channel.encoding != "json":
            raise UserError(f"{channel.topic} is heard in JSON, not in {channel.encoding}")
        try:
            message = orjson.loads(data)
        except orjson.JSONDecodeError as error:
            raise UserError(f"what was published on {channel.topic} is not JSON: {error}") from error
        self._controls.wish_goal(goal_in(message))

    def _try(self, act: Callable[[], None]) -> None:
        try:
            act()
        except UserError as error:
            self._refuse(str(error))
