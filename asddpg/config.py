"""Options of a training, an evaluation, episodes to play and missions, each with its range and its meaning beside it.

A field without option() is no option: the name of a choice, such as task.name, which task= sets.
"""

from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

from asddpg.errors import UserError
from asddpg.options.values import check_value
from tasks import LaserConfig, NavigationConfig, Reward
from tasks.constants import NUM_SCANS
from tasks.gymnasium_api.flat_observation import SCANS
from tasks.options import NOT_NEGATIVE, POSITIVE, SHARE, Range, between, one_of, option, options_of, some_of
from tasks.rewards import REWARDS, Outcome
from tasks.robots.names import ROBOTS

SEED = Range(lambda value: 0 <= value < 2**63, "from 0 to 2^63 − 1")
EPISODES = Range(lambda value: 1 <= value <= 10**6, "from 1 to a million")
PORT = between(0, 65_535)
DISCOUNT = Range(lambda value: 0 <= value < 1, "from 0 to below 1")
POSITIVE_SHARE = Range(lambda value: 0 < value <= 1, "above 0 and up to 1")
NOISE_LOSS = Range(lambda value: 0 <= value < 2, "from 0 to below 2, where the noise would grow without bound")
BUFFER = Range(lambda value: 0 < value <= 10**7, "from 1 to 10 million")
LAYERS = Range(
    lambda widths: 2 <= len(widths) <= 100 and all(1 <= width <= 65_536 for width in widths),
    "two or more layers, up to 100, of 1 to 65536 neurons",
)
GAINS = Range(
    lambda gains: len(gains) == 2 and all(abs(gain) < 1e6 for gain in gains),
    "two numbers within a million, P_l and P_r",
)
BINS = Range(lambda bins: bins == 0 or 11 <= bins <= 1001, "0, or from 11 to 1001")
CAMERAS = Range(lambda names: len(set(names)) == len(names), "names of cameras, each once")
NAMES = Range(lambda names: len(set(names)) == len(names), "names of obstacles, each once")
TARGETS = Range(lambda numbers: len(numbers) % 2 == 0, "pairs of numbers, x and y of each target, such as [1,2,-3,0.5]")
START = Range(lambda numbers: len(numbers) in (0, 3), "three numbers, x, y (m) and yaw (rad)")
PICTURE_SIZE = Range(
    lambda size: len(size) == 2 and all(16 <= side <= 1080 and side % 2 == 0 for side in size),
    "width and height, two even numbers from 16 to 1080 px",
)
EPISODE_NUMBERS = Range(lambda numbers: all(number >= 1 for number in numbers), "numbers of episodes, counted from 1")
OUTCOMES = some_of(*(str(outcome) for outcome in Outcome if outcome is not Outcome.RUNNING))
MIN_BEAMS = 12  # of the convolutions, which halve a scan twice

# Sentences of several options.
_DEVICE = "Where the networks are computed: cpu, cuda or cuda:<n>."
_PORT = "Port of the WebSocket; 0 takes a free one."
_EVERY = "Episodes from one recorded to the next; 1 records all, 0 none."


@dataclass
class TaskConfig(NavigationConfig):
    """The room and the constants of the task."""

    name: str = "nav_complex"
    num_scans: int = option(NUM_SCANS, "Scans stacked in the observation.", SCANS)


@dataclass
class NetworkConfig:
    """Layers of policy and critic."""

    name: str = "fc3x256"
    widths: list[int] = option(
        [256, 256, 256], "Neurons of each fully connected layer, in policy and critic alike.", LAYERS
    )
    layer_norm: bool = option(False, "Whether the critic branch normalises each hidden layer (Ba et al., 2016).")
    ranges: str = option(
        "linear",
        "How the convolutions see ranges: linear, as the released code, or log, which spreads the near ones.",
        one_of("linear", "log"),
    )
    convolutions: str = option(
        "separate",
        "Convolutions of the scan: policy and critic each their own, the critic's for both, or none.",
        one_of("separate", "shared", "none"),
    )


@dataclass
class WithdrawalConfig:
    """A schedule that takes the controller away: the share of episodes that the actor drives alone."""

    first_share: float = option(0.0, "Share of episodes driven by the actor alone at first.", SHARE)
    last_share: float = option(1.0, "Share of episodes driven by the actor alone in the end.", SHARE)
    begin: float = option(0.1, "Share of training after which the first share begins to change.", SHARE)
    end: float = option(0.9, "Share of training after which the last share is reached.", SHARE)
    stretch_steps: int = option(
        0, "Steps between two draws of the driver in an episode; 0 draws once an episode.", NOT_NEGATIVE
    )


@dataclass
class AgentConfig:
    """How AsDDPG learns."""

    name: str = "asddpg"
    assisted: bool = option(True, "Whether a controller assists; without one AsDDPG is DDPG.")
    gamma: float = option(0.99, "γ, discount of a step.", DISCOUNT)
    tau: float = option(0.01, "τ, share of the way the targets move at each update.", POSITIVE_SHARE)
    actor_learning_rate: float = option(4e-4, "Learning rate of the policy (Adam).", POSITIVE)
    critic_learning_rate: float = option(1.2e-3, "Learning rate of the Critic-DQN (Adam).", POSITIVE)
    batch_size: int = option(256, "N of Algorithm 1, transitions an update.", POSITIVE)
    samples_per_step: int = option(
        16,
        "Transitions learned from for each training step: an update is due after every batch_size of them.",
        POSITIVE,
    )
    buffer_size: int = option(100_000, "Transitions the replay buffer holds.", BUFFER)
    learning_starts: int = option(1000, "Transitions gathered before the first update.", NOT_NEGATIVE)
    gamma_p: float = option(0.5, "γ_p on the controller's positive dense rewards; 1 makes its help free.", SHARE)
    controller_price: float = option(0.0, "Taken off each of the controller's steps, under any reward.", NOT_NEGATIVE)
    charge_critic: bool = option(
        False, "Whether γ_p and the price act in y^A too (the paper's Eq. 4), not in y^Q alone."
    )
    critic_follows_switch: bool = option(
        False, "Whether Q^A bootstraps from max_σ Q, the switch's value; else from itself (Eq. 4)."
    )
    imitation: float = option(
        1.0, "Weight of imitating the controller where the critic prefers it; 0 for none.", NOT_NEGATIVE
    )
    saturation: float = option(
        0.01, "Weight of keeping the policy's outputs where tanh has a slope; 0 for none.", NOT_NEGATIVE
    )
    smoothness: float = option(
        0.0, "Weight of keeping the policy's action from one state to the next (CAPS); 0 for none.", NOT_NEGATIVE
    )
    n_steps: int = option(3, "Steps that a return reaches ahead before it bootstraps.", between(1, 100))
    twin_critics: bool = option(
        False, "Whether the smaller one of two critics bootstraps (TD3, Fujimoto et al., 2018)."
    )
    target_noise: float = option(
        0.0, "σ of the noise on π' in y^A, in half an action's range, cut at 2 σ (TD3: 0.2).", NOT_NEGATIVE
    )
    value_bins: int = option(
        0, "Bins over which Q^A is a distribution, learned by cross-entropy (HL-Gauss); 0 for a single number.", BINS
    )
    policy_every: int = option(2, "Updates of the critic for each of the policy (as in TD3).", POSITIVE)
    balanced_batches: bool = option(
        False, "Whether half a batch comes from the actor's steps, half from the controller's."
    )
    annealing: float = option(
        0.3, "Share of training, at its end, in which the learning rates fall linearly to zero.", SHARE
    )
    precision: str = option(
        "float32",
        "Of the hidden layers while learning: bfloat16 is faster on processors that multiply it, slower on others.",
        one_of("float32", "bfloat16"),
    )
    withdrawal: WithdrawalConfig = field(default_factory=WithdrawalConfig)


@dataclass
class ControllerConfig:
    """The controller that assists, or drives alone as a baseline."""

    type: str = option("proportional", "proportional, or a class of your own as package.module:Factory.")
    gains: list[float] = option([1.0, 1.0], "P_l in 1/s and P_r in rad/(s·m).", GAINS)


@dataclass
class ExplorationConfig:
    """Ornstein-Uhlenbeck noise on the policy's actions, in units of half an action's range."""

    theta: float = option(0.15, "Share of the noise lost at each step.", NOISE_LOSS)
    sigma: float = option(0.2, "Standard deviation of what each step adds.", NOT_NEGATIVE)
    decay: float = option(
        0.8, "Share of training in which the noise fades to its final scale; 0 fades it at once.", SHARE
    )
    final_scale: float = option(0.1, "Scale of the noise from then on.", SHARE)


@dataclass
class ValidationConfig:
    """Evaluations of the actor alone on the stored validation set, while training."""

    every: int = option(5_000, "Training steps between two validations; 0 for none.", NOT_NEGATIVE)
    episodes: int = option(50, "Pairs used.", between(1, 50, ", the size of the stored validation set"))
    snapshots: bool = option(True, "Whether each keeps the networks' weights, for tools.diagnose.")


@dataclass
class PictureConfig:
    """Pictures by cameras of the scene."""

    cameras: list[str] = option(
        [], "Cameras whose pictures are recorded, and shown live, such as [chase,onboard].", CAMERAS
    )
    codec: str = option(
        "jpeg", "Form of the pictures; h264 halves the files: pip install 'asddpg[video]'.", one_of("jpeg", "h264")
    )
    picture_size: list[int] = option([320, 240], "Width and height of the pictures, px.", PICTURE_SIZE)


@dataclass
class RecordConfig(PictureConfig):
    """Recordings of episodes for Foxglove, episodes/*.mcap in the run's folder. They change nothing that is learned."""

    every: int = option(50, _EVERY, NOT_NEGATIVE)
    keep: int = option(200, "Recordings kept at most; older ones are deleted.", POSITIVE)


@dataclass
class RecordEvaluationConfig(PictureConfig):
    """Recordings of the episodes for Foxglove, *.mcap in evaluated_episodes/ or played_episodes/."""

    every: int = option(0, _EVERY, NOT_NEGATIVE)
    only: list[int] = option([], "Numbers of further episodes to record.", EPISODE_NUMBERS)
    outcomes: list[str] = option(
        [], "Outcomes whose recordings are kept; [] keeps all. Alone it means every=1.", OUTCOMES
    )


@dataclass
class TrainConfig:
    """`python -m asddpg.train`."""

    task: TaskConfig = field(default_factory=TaskConfig)
    reward: Reward = field(default_factory=lambda: replace(REWARDS["sparse"]))
    network: NetworkConfig = field(default_factory=NetworkConfig)
    agent: AgentConfig = field(default_factory=AgentConfig)
    controller: ControllerConfig = field(default_factory=ControllerConfig)
    exploration: ExplorationConfig = field(default_factory=ExplorationConfig)
    validation: ValidationConfig = field(default_factory=ValidationConfig)
    record: RecordConfig = field(default_factory=RecordConfig)
    seed: int = option(0, "Seed of all random streams of the run.", SEED)
    robots: int = option(16, "Robots that drive side by side; 1 is the paper's Algorithm 1.", between(1, 4096))
    safety_margin: float = option(
        0.0, "Metres from an obstacle that end an episode as a collision, in training alone.", between(0, 0.2, " m")
    )
    total_steps: int = option(100_000, "Control steps to train for, of all robots together.", POSITIVE)
    checkpoint_every: int = option(
        10_000, "Steps between two training states, for resume=; 0 writes the last one alone.", NOT_NEGATIVE
    )
    test_episodes: int = option(200, "Stored test pairs that the trained actor drives; 0 for none.", between(0, 200))
    run_dir: str | None = option(None, "Folder of the run; null makes runs/<time>_<task>_<agent>_seed<seed>.")
    device: str = option("cpu", _DEVICE)
    live: bool = option(False, "Whether Foxglove can watch over a WebSocket; nothing that is learned changes.")
    port: int = option(8765, _PORT, PORT)
    speed: float = option(
        0.0, "Simulated seconds per second while a viewer watches; 0 is as fast as possible.", NOT_NEGATIVE
    )


@dataclass
class PlannerConfig:
    """Map and global planner of agent=move_base and agent=waypoints."""

    map: str = option(
        "known",
        "What the planner knows of the room: known, or built from scans while driving.",
        one_of("known", "built"),
    )
    look_ahead: float = option(1.0, "Metres along the path to the waypoint of agent=waypoints.", between(0.1, 10))


def _from_laser(name: str) -> Any:
    """An option of the laser, where null leaves the one there is."""
    (found,) = (each for each in options_of(LaserConfig) if each.name == name)
    return option(None, found.meaning, found.range)


@dataclass
class LaserChange:
    """Another laser than the run's or the task's; null leaves that one's. A policy takes its beams from it by angle.

    The rays of that one's beams, where they have several, are the beams of the other.
    """

    num_beams: int | None = _from_laser("num_beams")
    field_of_view: float | None = _from_laser("field_of_view")
    min_range: float | None = _from_laser("min_range")
    max_range: float | None = _from_laser("max_range")
    height: float | None = _from_laser("height")

    def apply(self, laser: LaserConfig) -> LaserConfig:
        """The changed laser; TaskError where values contradict one another."""
        given = {name: value for name, value in vars(self).items() if value is not None}
        if given and laser.rays_per_beam > 1:
            given = {"num_beams": laser.num_rays, "rays_per_beam": 1} | given
        return replace(laser, **given)


@dataclass
class DriverConfig:
    """Which driver drives, and where."""

    run: str | None = option(None, "Folder of a run, or pretrained:<name>; null with the agent= of a baseline.")
    checkpoint: str = option("last", "Checkpoint of a run's folder.", one_of("last", "best"))
    driver: str = option(
        "actor", "Driver of a run: its actor alone, or actor and controller by its switch.", one_of("actor", "switch")
    )
    agent: str | None = option(
        None,
        "Instead of a run: controller, random, move_base (planner and DWA), or package.module:Factory; waypoints leads "
        "the controller, or the driver of run=, along a planner's path.",
    )
    task: str | None = option(None, "The task to drive; null takes the run's.")
    robot: str | None = option(None, f"The robot: {ROBOTS}; null takes the run's, or the Pioneer.")
    controller: ControllerConfig = field(default_factory=ControllerConfig)
    planner: PlannerConfig = field(default_factory=PlannerConfig)
    laser: LaserChange = field(default_factory=LaserChange)
    device: str = option("cpu", _DEVICE)
    out: str | None = option(
        None, "Folder for results and recordings; null takes the run's or, of another driver, the present one."
    )


@dataclass
class EvaluateConfig(DriverConfig):
    """`python -m asddpg.evaluate`."""

    episodes: int = option(200, "Episodes to drive.", EPISODES)
    seed: int | None = option(None, "Of freshly drawn start-goal pairs; null takes the stored test set.", SEED)
    record: RecordEvaluationConfig = field(default_factory=RecordEvaluationConfig)


@dataclass
class PlayConfig(DriverConfig):
    """`python -m asddpg.play`."""

    driver: str = option(
        "actor",
        "Driver of a run: its actor, actor and controller by its switch, or its controller.",
        one_of("actor", "switch", "controller"),
    )
    episodes: int | None = option(None, "Episodes to drive; null drives 3, and with live=true until Ctrl-C.", EPISODES)
    seed: int | None = option(None, "Of the starts and goals; null draws one, which is printed.", SEED)
    record: RecordEvaluationConfig = field(default_factory=lambda: RecordEvaluationConfig(every=1))
    video: str | None = option(None, "A film of the episodes, .mp4; null makes none.")
    camera: str = option("chase", "Camera of the film: one of the scene, or free for the whole of it.")
    live: bool = option(False, "Whether Foxglove can watch and steer, over a WebSocket of this machine.")
    port: int = option(8765, _PORT, PORT)
    speed: float = option(1.0, "Simulated seconds per second when live; 0 is as fast as possible.", NOT_NEGATIVE)


@dataclass
class MissionConfig(DriverConfig):
    """`python -m asddpg.mission`."""

    targets: list[float] = option([], "x and y of the targets in turn, m; [] draws five, by the seed.", TARGETS)
    start: list[float] = option([], "x, y (m) and yaw (rad) of the start; [] draws it.", START)
    unmapped: list[str] | None = option(
        None, "Obstacles that the map lacks, such as [sofa,bench]; null draws five, [] lets it lack nothing.", NAMES
    )
    noise: float = option(1.0, "Scale of the laser's noise; 1 is that of a real URG-04LX.", NOT_NEGATIVE)
    drift: float = option(0.05, "By how much odometry takes lengths and turns for too long.", between(-0.5, 0.5))
    within: float = option(0.3, "Metres from a target, by the robot's own estimate, that count as reached.", POSITIVE)
    patience: float = option(120.0, "Simulated seconds for each target.", POSITIVE)
    missions: int | None = option(None, "Missions to drive; null drives 1, and with live=true until Ctrl-C.", EPISODES)
    seed: int = option(0, "Of starts, targets, unmapped obstacles, noise and particles.", SEED)
    record: RecordEvaluationConfig = field(default_factory=lambda: RecordEvaluationConfig(every=1))
    live: bool = option(False, "Whether Foxglove can watch, and set targets by a click.")
    port: int = option(8765, _PORT, PORT)
    speed: float = option(1.0, "Simulated seconds per second when live; 0 is as fast as possible.", NOT_NEGATIVE)


DrivingConfig: TypeAlias = EvaluateConfig | PlayConfig | MissionConfig


def check(config: TrainConfig | DrivingConfig) -> None:
    """Check every value against its range, and values against one another.

    Raises:
        UserError: the first that is wrong, and what would be right.
    """
    for each in options_of(config):
        check_value(each, each.value)
    _check_cameras(config.record, is_live=getattr(config, "live", False))
    if isinstance(config, PlayConfig) and config.video is None and config.camera != PlayConfig.camera:
        raise UserError("camera chooses whose pictures a film shows, and none is made: video=out.mp4 makes one")
    if isinstance(config, TrainConfig):
        _check_convolutions(config)
        _check_buffer(config.agent, config.robots)
        _check_assistance(config.agent)


def _check_cameras(record: PictureConfig, is_live: bool) -> None:
    is_recorded = getattr(record, "every", 0) or getattr(record, "only", [])
    if record.cameras and not is_live and not is_recorded:
        raise UserError("record.cameras adds pictures to recordings, and none is made: record.every=1 records all")


def _check_convolutions(config: TrainConfig) -> None:
    if config.network.ranges == "log" and config.network.convolutions == "none":
        raise UserError("network.ranges=log needs convolutions; network.convolutions=none takes network.ranges=linear")
    beams = config.task.laser.num_beams
    if config.network.convolutions != "none" and beams < MIN_BEAMS:
        fewer = "fewer need network.convolutions=none"
        raise UserError(f"task.laser.num_beams must be {MIN_BEAMS} or more for the convolutions, not {beams}; {fewer}")


# Without a controller they would do nothing.
_ASSISTANCE_ONLY = ("imitation", "critic_follows_switch", "balanced_batches", "controller_price", "charge_critic")


def _check_assistance(agent: AgentConfig) -> None:
    idle = [] if agent.assisted else [name for name in _ASSISTANCE_ONLY if getattr(agent, name)]
    if idle:
        raise UserError(f"agent.{idle[0]} needs a controller: agent.assisted=true, or agent.{idle[0]} off")
    if agent.assisted and agent.critic_follows_switch and (agent.twin_critics or agent.target_noise):
        cure = "agent.critic_follows_switch=false, the default"
        raise UserError(f"agent.twin_critics and agent.target_noise act where Q^A bootstraps from itself: {cure}")
    begin, end = agent.withdrawal.begin, agent.withdrawal.end
    if begin > end:
        raise UserError(f"agent.withdrawal.begin, {begin}, must not come after .end, {end}")


def _check_buffer(agent: AgentConfig, robots: int) -> None:
    sizes = {"agent.batch_size": agent.batch_size, "agent.learning_starts": agent.learning_starts, "robots": robots}
    for name, value in sizes.items():
        if value > agent.buffer_size:
            raise UserError(f"{name} must be at most agent.buffer_size, {agent.buffer_size}, not {value}")
    if agent.balanced_batches and agent.batch_size < 2:
        raise UserError("agent.balanced_batches needs an agent.batch_size of 2 or more")
