"""Takes subscriptions and requests of a live view's viewers; Foxglove's server calls it from its own threads."""

from collections.abc import Callable

import orjson
from foxglove.websocket import ChannelView, Client, ClientChannel, Parameter, ServerListener

from asddpg.errors import UserError
from asddpg.recording.live.controls import LiveControls, parse_goal

# Where Foxglove's 3D panel publishes a click on the floor, by its defaults, and ROS 2's name of the same.
GOAL_TOPICS = ("/clicked_point", "/move_base_simple/goal", "/goal_pose")


class LiveListener(ServerListener):
    """Keeps the subscriptions, and passes requests on to the controls."""

    def __init__(self, controls: LiveControls, refuse: Callable[[str], None]) -> None:
        """Pass requests on to the controls; `refuse` sends the viewers the reason why one is refused."""
        self._controls, self._refuse = controls, refuse
        self._subscriptions: set[tuple[int, int]] = set()  # client and channel
        self._has_new_subscription = False
        self._topics: dict[tuple[int, int], ClientChannel] = {}

    @property
    def has_viewers(self) -> bool:
        """Whether there is any subscription."""
        return bool(self._subscriptions)

    def take_subscription(self) -> bool:
        """Whether there was a new subscription since the last call."""
        if not self._has_new_subscription:
            return False  # without a write, which would lose one that comes at this moment
        self._has_new_subscription = False
        return True

    # Subscriptions ------------------------------------------------------------------------------------------------

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """Note a new subscription: late subscribers get the full state."""
        self._subscriptions.add((client.id, channel.id))
        self._has_new_subscription = True
        self._controls.wake_event.set()

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        """Forget a subscription; also called when a viewer has disconnected."""
        self._subscriptions.discard((client.id, channel.id))
        self._controls.wake_event.set()

    # Parameters ---------------------------------------------------------------------------------------------------

    def on_get_parameters(
        self, client: Client, param_names: list[str], request_id: str | None = None
    ) -> list[Parameter]:
        """The requested parameters, or all."""
        return [each for each in self.parameters() if not param_names or each.name in param_names]

    def on_set_parameters(
        self, client: Client, parameters: list[Parameter], request_id: str | None = None
    ) -> list[Parameter]:
        """Set parameters; a refused one keeps its value."""
        for parameter in parameters:
            self._try(lambda each=parameter: self._controls.set(each.name, each.get_value()))  # type: ignore[misc]
        return self.parameters()

    def parameters(self) -> list[Parameter]:
        """All parameters with their values."""
        return [Parameter(name, value=value) for name, value in self._controls.values().items()]

    # Goals --------------------------------------------------------------------------------------------------------

    def on_client_advertise(self, client: Client, channel: ClientChannel) -> None:
        """Note a channel that a viewer will publish on."""
        self._topics[client.id, channel.id] = channel

    def on_client_unadvertise(self, client: Client, client_channel_id: int) -> None:
        """Forget such a channel."""
        self._topics.pop((client.id, client_channel_id), None)

    def on_message_data(self, client: Client, client_channel_id: int, data: bytes) -> None:
        """Request the goal that a viewer has published."""
        self._try(lambda: self._receive_goal(self._topics[client.id, client_channel_id], data))

    def _receive_goal(self, channel: ClientChannel, data: bytes) -> None:
        if channel.topic not in GOAL_TOPICS:
            raise UserError(f"there is no subscriber to {channel.topic}; goals are taken from {', '.join(GOAL_TOPICS)}")
        if channel.encoding != "json":
            raise UserError(f"{channel.topic} must be in JSON, not in {channel.encoding}")
        try:
            message = orjson.loads(data)
        except orjson.JSONDecodeError as error:
            raise UserError(f"what was published on {channel.topic} is not JSON: {error}") from error
        self._controls.request_goal(parse_goal(message))

    def _try(self, act: Callable[[], None]) -> None:
        try:
            act()
        except UserError as error:
            self._refuse(str(error))
