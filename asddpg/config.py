"""Every option of a training, of an evaluation and of episodes that are played, its default and its range."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from asddpg.errors import UserError, truncated_repr


@dataclass
class LaserConfig:
    """What the laser does; by default it is perfect."""

    # Beams over 240 degrees; the paper's code keeps 40, the real one has 682.
    num_beams: int = 40
    # Scale of the noise on every range; 1 is a real URG-04LX's, 0 none.
    noise: float = 0.0
    # Probability that a beam returns nothing; it then reads the maximum range.
    dropout: float = 0.0
    # Seconds from the instant a scan is of to the end of the control step that returns it.
    latency: float = 0.0


@dataclass
class TaskConfig:
    """The room and the constants of the task."""

    # One of tasks.ALL_TASKS.
    name: str = "nav_complex"
    # Seconds between two commands.
    control_timestep: float = 0.2
    # Metres between base and goal at which the goal counts as reached.
    goal_radius: float = 0.3
    # Steps after which an episode is broken off.
    time_limit_steps: int = 200
    # m/s; the released code keeps v at 0.05 or more.
    min_linear_velocity: float = 0.0
    # m/s.
    max_linear_velocity: float = 0.5
    # rad/s.
    max_angular_velocity: float = 1.0471975511965976
    # Scans stacked in the observation.
    num_scans: int = 3
    laser: LaserConfig = field(default_factory=LaserConfig)


@dataclass
class RewardConfig:
    """Constants of the reward; tasks/rewards.py gives the formula."""

    name: str = "sparse"
    progress: float = 0.0
    time_penalty: float = 0.05
    reach: float = 5.0
    crash: float = -5.0


@dataclass
class NetworkConfig:
    """Layers of policy and critic."""

    name: str = "fc3x256"
    # Neurons of each fully connected layer, alike in policy and critic.
    widths: list[int] = field(default_factory=lambda: [256, 256, 256])
    # Whether the critic branch normalises each hidden layer (Ba et al., 2016).
    layer_norm: bool = False
    # separate: policy and critic each have their own; shared: the policy looks through the critic's, trained by Eq. 4;
    # none: the scan goes straight to the fully connected layers, as in the released code.
    convolutions: str = "separate"


@dataclass
class WithdrawalConfig:
    """A schedule that takes the controller away: the share of episodes that the actor drives alone."""

    # Share at first.
    first_share: float = 0.0
    # Share in the end.
    last_share: float = 1.0
    # Shares of training between which it goes from the one to the other.
    begin: float = 0.1
    end: float = 0.9
    # Steps after which is drawn anew within an episode; 0 draws for whole episodes.
    stretch_steps: int = 0


@dataclass
class LearningConfig:
    """How AsDDPG learns."""

    name: str = "asddpg"
    # Whether a controller assists; without one AsDDPG is DDPG.
    assisted: bool = True
    # γ, discount of a step.
    gamma: float = 0.99
    # τ, share of the way the targets move at each update.
    tau: float = 0.005
    # Learning rate of the policy (Adam).
    actor_learning_rate: float = 1e-4
    # Learning rate of the Critic-DQN (Adam).
    critic_learning_rate: float = 3e-4
    # N of Algorithm 1, transitions an update.
    batch_size: int = 32
    # Transitions the replay buffer holds.
    buffer_size: int = 100_000
    # Transitions gathered before the first update.
    learning_starts: int = 1000
    # γ_p on the controller's positive dense rewards; 1 makes its help free.
    gamma_p: float = 0.5
    # Taken off each of the controller's steps, under any reward.
    controller_price: float = 0.0
    # Whether γ_p and the price act in y^A too, as in the paper's Eq. 4, or in y^Q alone.
    charge_critic: bool = False
    # Whether Q^A bootstraps from the switch's value, Q'(x', argmax_σ Q), or from Q^A'(x', π'(x')), the paper's Eq. 4.
    critic_follows_switch: bool = True
    # Weight of imitating the controller where the critic prefers its action; 0 leaves the paper's Eq. 5.
    imitation: float = 1.0
    # Steps that a return reaches ahead before it bootstraps.
    n_steps: int = 3
    # Two critics, the smaller one bootstraps (TD3, Fujimoto et al., 2018).
    twin_critics: bool = False
    # σ of the noise on π' in y^A, in units of half an action's range, cut at twice that (after TD3: 0.2, cut at 0.5).
    target_noise: float = 0.0
    # Updates of the critic for each of the policy (after TD3, which delays the critic's target too).
    policy_every: int = 2
    # Whether a batch is half from the actor's steps and half from the controller's.
    balanced_batches: bool = False
    # Share of training, at its end, over which the learning rates decay linearly to zero.
    annealing: float = 0.3
    withdrawal: WithdrawalConfig = field(default_factory=WithdrawalConfig)


@dataclass
class ControllerConfig:
    """The controller that assists, or drives alone as a baseline."""

    # `proportional`, or one's own as package.module:Factory.
    type: str = "proportional"
    # P_l in 1/s and P_r in rad/(s·m).
    gains: list[float] = field(default_factory=lambda: [1.0, 1.0])


@dataclass
class ExplorationConfig:
    """Ornstein-Uhlenbeck noise on the policy's actions, in units of half an action's range."""

    # Share of the noise lost at each step.
    theta: float = 0.15
    # Standard deviation of what each step adds.
    sigma: float = 0.2
    # Share of training over which the noise fades to its final scale; 0 fades it at once.
    decay: float = 0.8
    # Scale from then on.
    final_scale: float = 0.1


@dataclass
class ValidationConfig:
    """Evaluations of the actor alone on the stored validation set, while training."""

    # Training steps between two; 0 for none.
    every: int = 5_000
    # Pairs used, of the 50 stored.
    episodes: int = 50
    # Whether each keeps the networks' weights, for tools.diagnose.
    snapshots: bool = True


@dataclass
class RecordConfig:
    """Recordings of episodes for Foxglove, episodes/*.mcap in the run's folder. They change nothing that is learned."""

    # Episodes between two recorded ones, the first among them; 1 records all, 0 none.
    every: int = 50
    # Recordings kept at most; the oldest go.
    keep: int = 200
    # Cameras of the scene whose pictures are recorded too, such as [chase,onboard], and shown live.
    cameras: list[str] = field(default_factory=list)
    # Of the pictures: jpeg, or h264, which takes half the room and needs PyAV (pip install av).
    codec: str = "jpeg"
    # Width and height of the pictures, px.
    picture_size: list[int] = field(default_factory=lambda: [320, 240])


@dataclass
class RecordEvaluationConfig:
    """Recordings of an evaluation's episodes for Foxglove, evaluated_episodes/*.mcap beside evaluation.json."""

    # Episodes between two recorded ones, the first among them; 1 records all, 0 none.
    every: int = 0
    # Numbers of episodes that are recorded besides, counted from 1.
    only: list[int] = field(default_factory=list)
    # Outcomes whose recordings are kept: reached, crashed, timeout; empty keeps all. Alone it means every=1.
    outcomes: list[str] = field(default_factory=list)
    # Cameras of the scene whose pictures are recorded too, such as [chase,onboard], and that play shows live.
    cameras: list[str] = field(default_factory=list)
    # Of the pictures: jpeg, or h264, which takes half the room and needs PyAV (pip install av).
    codec: str = "jpeg"
    # Width and height of the pictures, px.
    picture_size: list[int] = field(default_factory=lambda: [320, 240])


@dataclass
class TrainConfig:
    """`python -m asddpg.train`."""

    task: TaskConfig = field(default_factory=TaskConfig)
    reward: RewardConfig = field(default_factory=RewardConfig)
    network: NetworkConfig = field(default_factory=NetworkConfig)
    agent: LearningConfig = field(default_factory=LearningConfig)
    controller: ControllerConfig = field(default_factory=ControllerConfig)
    exploration: ExplorationConfig = field(default_factory=ExplorationConfig)
    validation: ValidationConfig = field(default_factory=ValidationConfig)
    record: RecordConfig = field(default_factory=RecordConfig)
    # Of every random stream of the run.
    seed: int = 0
    # Control steps to train for.
    total_steps: int = 100_000
    # Training steps between two checkpoints, from which resume= goes on; 0 for the last one alone.
    checkpoint_every: int = 10_000
    # Pairs of the stored test set, of 200, that the trained actor is tested on; 0 for none.
    test_episodes: int = 200
    # Where the run is kept; null makes runs/<time>_<task>_<agent>_seed<seed>.
    run_dir: str | None = None
    # cpu, cuda or cuda:<n>.
    device: str = "cpu"
    # Whether Foxglove can watch, over a WebSocket of this machine. It changes nothing that is learned.
    live: bool = False
    # Of the WebSocket; 0 takes a free one.
    port: int = 8765
    # Simulated seconds a second while somebody watches; 0 goes as fast as it can.
    speed: float = 0.0


@dataclass
class DrivingConfig:
    """Who is to drive, and where."""

    # Folder of a training run, or pretrained:<name>; null with agent=controller or agent=random.
    run: str | None = None
    # Checkpoint of a run's folder: last or best.
    checkpoint: str = "last"
    # Who drives a trained run: actor (alone, no noise) or switch (actor and controller).
    driver: str = "actor"
    # A baseline instead of a run: controller or random.
    agent: str | None = None
    # null takes the run's.
    task: str | None = None
    controller: ControllerConfig = field(default_factory=ControllerConfig)
    device: str = "cpu"


@dataclass
class EvaluateConfig(DrivingConfig):
    """`python -m asddpg.evaluate`."""

    episodes: int = 200
    # Of freshly drawn start-goal pairs; null takes the stored test set.
    seed: int | None = None
    record: RecordEvaluationConfig = field(default_factory=RecordEvaluationConfig)


@dataclass
class PlayConfig(DrivingConfig):
    """`python -m asddpg.play`; `driver` may also be controller, the run's own alone."""

    # null drives 3, and with live=true until Ctrl-C.
    episodes: int | None = None
    # Of the starts and goals; null draws one, which is printed.
    seed: int | None = None
    # Into played_episodes/.
    record: RecordEvaluationConfig = field(default_factory=lambda: RecordEvaluationConfig(every=1))
    # A film of the episodes, .mp4; null makes none.
    video: str | None = None
    # Whose pictures the film shows: a camera of the scene, or free for the whole of it.
    camera: str = "chase"
    # Whether Foxglove can watch and steer, over a WebSocket of this machine.
    live: bool = False
    # Of the WebSocket; 0 takes a free one.
    port: int = 8765
    # Simulated seconds a second when live; 0 goes as fast as it can.
    speed: float = 1.0


def _positive(value: float) -> bool:
    return value > 0


def _not_negative(value: float) -> bool:
    return value >= 0


def _share(value: float) -> bool:
    return 0 <= value <= 1


def _two_finite(values: list[float]) -> bool:
    return len(values) == 2 and all(abs(value) < 1e6 for value in values)


def _multiple_of_physics_step(seconds: float) -> bool:
    steps = seconds / 0.005
    return 0.01 <= seconds <= 2 and abs(steps - round(steps)) < 1e-6


def _layers(widths: list[int]) -> bool:
    return 2 <= len(widths) <= 100 and all(1 <= width <= 65_536 for width in widths)


def _picture_size(size: list[int]) -> bool:
    return len(size) == 2 and all(16 <= side <= 1080 and side % 2 == 0 for side in size)


TOO_LARGE = 2**63  # no option needs such a whole number, and not everything that counts can hold it

OUTCOMES = frozenset({"reached", "crashed", "timeout"})

Rule = tuple[Callable[[Any], bool], str]

_POSITIVE: Rule = (_positive, "greater than 0")
_NOT_NEGATIVE: Rule = (_not_negative, "0 or more")
_SHARE: Rule = (_share, "from 0 to 1")
_SEED: Rule = (lambda value: 0 <= value < 2**63, "from 0 to 2^63 − 1")

RULES: dict[str, Rule] = {
    "seed": _SEED,
    "total_steps": _POSITIVE,
    "test_episodes": (lambda value: 0 <= value <= 200, "from 0 to 200, the size of the stored test set"),
    "checkpoint_every": _NOT_NEGATIVE,
    "episodes": (lambda value: 1 <= value <= 10**6, "from 1 to a million"),
    "validation.every": _NOT_NEGATIVE,
    "record.every": _NOT_NEGATIVE,
    "record.keep": _POSITIVE,
    "record.only": (lambda numbers: all(number >= 1 for number in numbers), "numbers of episodes, counted from 1"),
    "record.outcomes": (lambda outcomes: set(outcomes) <= OUTCOMES, f"some of {', '.join(sorted(OUTCOMES))}"),
    "record.cameras": (lambda names: len(set(names)) == len(names), "names of cameras, each once"),
    "record.codec": (lambda codec: codec in ("jpeg", "h264"), "jpeg or h264"),
    "record.picture_size": (_picture_size, "width and height, two even numbers from 16 to 1080 px"),
    "validation.episodes": (lambda value: 1 <= value <= 50, "from 1 to 50, the size of the stored validation set"),
    "task.control_timestep": (_multiple_of_physics_step, "from 0.01 to 2 s and a multiple of the physics step, 5 ms"),
    "task.goal_radius": (lambda value: 0.1 <= value <= 2, "from 0.1 to 2 m"),
    "task.time_limit_steps": _POSITIVE,
    "task.min_linear_velocity": _NOT_NEGATIVE,
    "task.max_linear_velocity": (lambda value: 0 < value <= 1.19, "above 0 and up to the robot's 1.19 m/s"),
    "task.max_angular_velocity": (lambda value: 0 < value <= 5.23, "above 0 and up to the robot's 5.23 rad/s"),
    "task.num_scans": (lambda value: 1 <= value <= 100, "from 1 to 100"),
    "task.laser.num_beams": (lambda value: 12 <= value <= 2000, "from 12 to 2000"),
    "task.laser.noise": _NOT_NEGATIVE,
    "task.laser.dropout": _SHARE,
    "task.laser.latency": (lambda value: 0 <= value <= 2, "from 0 to 2 s"),
    "reward.progress": _NOT_NEGATIVE,
    "reward.time_penalty": _NOT_NEGATIVE,
    "reward.reach": _NOT_NEGATIVE,
    "reward.crash": (lambda value: value <= 0, "0 or less"),
    "network.widths": (_layers, "two or more layers, up to 100, of 1 to 65536 neurons"),
    "network.convolutions": (lambda value: value in ("separate", "shared", "none"), "separate, shared or none"),
    "agent.gamma": (lambda value: 0 <= value < 1, "from 0 to below 1"),
    "agent.tau": (lambda value: 0 < value <= 1, "above 0 and up to 1"),
    "agent.actor_learning_rate": _POSITIVE,
    "agent.critic_learning_rate": _POSITIVE,
    "agent.batch_size": _POSITIVE,
    "agent.buffer_size": (lambda value: 0 < value <= 10**7, "from 1 to 10 million"),
    "agent.learning_starts": _NOT_NEGATIVE,
    "agent.gamma_p": _SHARE,
    "agent.imitation": _NOT_NEGATIVE,
    "agent.controller_price": _NOT_NEGATIVE,
    "agent.n_steps": (lambda value: 1 <= value <= 100, "from 1 to 100"),
    "agent.target_noise": _NOT_NEGATIVE,
    "agent.policy_every": _POSITIVE,
    "agent.annealing": _SHARE,
    "agent.withdrawal.first_share": _SHARE,
    "agent.withdrawal.last_share": _SHARE,
    "agent.withdrawal.begin": _SHARE,
    "agent.withdrawal.end": _SHARE,
    "agent.withdrawal.stretch_steps": _NOT_NEGATIVE,
    "controller.gains": (_two_finite, "two numbers within a million, P_l and P_r"),
    "exploration.theta": (lambda value: 0 <= value < 2, "from 0 to below 2, where the noise would grow without bound"),
    "exploration.sigma": _NOT_NEGATIVE,
    "exploration.decay": _SHARE,
    "exploration.final_scale": _SHARE,
    "checkpoint": (lambda value: value in ("last", "best"), "last or best"),
    "driver": (lambda value: value in ("actor", "switch"), "actor or switch"),
    "port": (lambda value: 0 <= value <= 65_535, "from 0 to 65535"),
    "speed": _NOT_NEGATIVE,
}

PLAY_RULES: dict[str, Rule] = {
    "driver": (lambda value: value in ("actor", "switch", "controller"), "actor, switch or controller"),
}


def check(config: TrainConfig | EvaluateConfig | PlayConfig) -> None:
    """Check every value against its range.

    Raises:
        UserError: the first value out of range, named with the range.
    """
    rules = RULES | PLAY_RULES if isinstance(config, PlayConfig) else RULES
    for name, (is_right, wanted) in rules.items():
        value = _lookup(config, name)
        if isinstance(value, float) and not math.isfinite(value):
            raise UserError(f"{name} must be a finite number, not {value}")
        if isinstance(value, int) and abs(value) >= TOO_LARGE:
            raise UserError(f"{name} must be within ±2^63, not {truncated_repr(value)}")
        if value is not None and not _holds(is_right, value):
            raise UserError(f"{name} must be {wanted}, not {truncated_repr(value)}")
    _check_cameras(config.record, is_live=getattr(config, "live", False))
    if isinstance(config, PlayConfig) and config.video is None and config.camera != PlayConfig.camera:
        raise UserError("camera chooses whose pictures a film shows, and none is made: video=out.mp4 makes one")
    if isinstance(config, TrainConfig):
        _check_buffer(config.agent)
        _check_assistance(config.agent)


def _holds(is_right: Callable[[Any], bool], value: Any) -> bool:
    try:
        return is_right(value)
    except TypeError:  # a list in a list, which no type of Hydra's keeps out
        return False


def _check_cameras(record: RecordConfig | RecordEvaluationConfig, is_live: bool) -> None:
    if record.cameras and not is_live and not record.every and not getattr(record, "only", []):
        raise UserError("record.cameras adds pictures to recordings, and none is made: record.every=1 records all")


# Without a controller they would do nothing.
_OF_ASSISTANCE = ("imitation", "critic_follows_switch", "balanced_batches", "controller_price", "charge_critic")


def _check_assistance(agent: LearningConfig) -> None:
    idle = [] if agent.assisted else [name for name in _OF_ASSISTANCE if getattr(agent, name)]
    if idle:
        raise UserError(f"agent.{idle[0]} needs a controller: agent.assisted=true, or agent.{idle[0]} off")
    if agent.assisted and agent.critic_follows_switch and (agent.twin_critics or agent.target_noise):
        wanted = "agent.critic_follows_switch=false, as in agent=astd3"
        raise UserError(f"agent.twin_critics and agent.target_noise act where Q^A bootstraps from itself: {wanted}")
    if agent.withdrawal.begin > agent.withdrawal.end:
        raise UserError(
            f"agent.withdrawal.begin, {agent.withdrawal.begin}, must not come after .end, {agent.withdrawal.end}"
        )


def _check_buffer(agent: LearningConfig) -> None:
    for name, value in (("batch_size", agent.batch_size), ("learning_starts", agent.learning_starts)):
        if value > agent.buffer_size:
            raise UserError(f"agent.{name} must be at most agent.buffer_size, {agent.buffer_size}, not {value}")
    if agent.balanced_batches and agent.batch_size < 2:
        raise UserError("agent.balanced_batches needs an agent.batch_size of 2 or more")


def _lookup(config: Any, name: str) -> Any:
    for part in name.split("."):
        config = getattr(config, part, None)
    return config
