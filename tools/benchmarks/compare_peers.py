"""Time of other algorithms to a good policy: `python -m tools.benchmarks.compare_peers [algorithm…]`.

Trains Stable-Baselines3's DDPG, TD3 and SAC with 16 robots of one vector environment, with the reward and the speeds of
our preset of the task, in networks of our widths with our convolutions, in three settings of its own each, until the
actor alone reaches 0.90 of the stored validation pairs or the limit is up. The limit counts the training alone; both
clocks are printed. One torch thread, denormal numbers flushed to zero, as in our training.
tools/benchmarks/peer_settings.py holds the settings and their reasons. A finished run is a file in the folder, and
is not trained again. `table` prints the table of the finished ones.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from asddpg.build import prepare_torch
from asddpg.command_line import train_config
from asddpg.config import TrainConfig
from asddpg.errors import UserError, import_extra
from asddpg.messages import print_line
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks import ALL_TASKS
from tasks.options import POSITIVE, SHARE, Range, argument, between, one_of, option, some_of
from tools.benchmarks.peer_runs import PeerRun, rates_of, table, train
from tools.benchmarks.peer_settings import ALGORITHMS, SETTINGS
from tools.experiments.runs import digest

SEEDS = Range(lambda seeds: seeds and all(0 <= seed < 2**31 for seed in seeds), "one or more, from 0 to 2^31 − 1")


@dataclass(frozen=True)
class PeersArguments:
    """What is trained, and how long."""

    algorithms: list[str] = argument(
        "Algorithms: ddpg, td3, sac; none takes all; table.", [], some_of(*ALGORITHMS, "table")
    )
    settings: list[str] = option([*SETTINGS], "Settings of each.", some_of(*SETTINGS))
    seeds: list[int] = option([100], "Seeds of each setting.", SEEDS)
    task: str = option("nav_complex", "The task.", one_of(*ALL_TASKS))
    limit_minutes: float = option(30.0, "Minutes of training at most, without evaluations.", POSITIVE)
    target: float = option(0.9, "Success rate of the actor alone that ends a run.", SHARE)
    every: int = option(5_000, "Steps of all robots between two evaluations.", POSITIVE)
    episodes: int = option(50, "Stored validation pairs used.", between(1, 50))
    folder: Path = option(Path("runs") / "peers", "Folder of the finished runs.")


@prepare_torch()
def main(arguments: Sequence[str]) -> None:
    """Train what is missing, and print the table."""
    parsed = parse_arguments(PeersArguments, arguments)
    if "table" not in parsed.algorithms:
        import_extra("stable_baselines3", "bench", "comparisons of training")
        parsed.folder.mkdir(parents=True, exist_ok=True)
        for peer in peers(parsed):
            path = parsed.folder / f"{peer.title}.json"
            if path.exists():
                _check_conditions(peer, path)
            else:
                _train(peer, parsed)
                peer.write(path)
    done = [PeerRun.read(path) for path in sorted(parsed.folder.glob("*.json"))]
    print_line(table(done) if done else f"there is no finished run in {parsed.folder}")


def peers(parsed: PeersArguments) -> list[PeerRun]:
    """The runs to make, not trained yet."""
    config = _config(parsed, seed=0)
    environment = digest({"task": asdict(config.task), "reward": asdict(config.reward), "episodes": parsed.episodes})
    return [
        PeerRun(parsed.task, algorithm, setting, seed, environment, parsed.target, parsed.limit_minutes)
        for seed in parsed.seeds
        for algorithm in parsed.algorithms or ALGORITHMS
        for setting in parsed.settings
    ]


def _config(parsed: PeersArguments, seed: int) -> TrainConfig:
    return train_config([f"task={parsed.task}", f"seed={seed}", f"validation.episodes={parsed.episodes}"])


def _check_conditions(peer: PeerRun, path: Path) -> None:
    found = PeerRun.read(path)
    if found.environment != peer.environment:
        raise UserError(f"{path} is a run in another task, reward or number of episodes; folder= takes another folder")
    if (found.target, found.limit_minutes) != (peer.target, peer.limit_minutes):
        conditions = f"target={found.target:g} limit_minutes={found.limit_minutes:g}"
        raise UserError(f"{path} is a run with {conditions}; folder= takes another folder for others")


def _train(peer: PeerRun, parsed: PeersArguments) -> None:
    from tools.benchmarks.stable_baselines import make_peer

    config = _config(parsed, peer.seed)
    model = make_peer(config, peer.algorithm, peer.setting)
    rates = rates_of(lambda seen: model.predict(seen, deterministic=True)[0], config)
    train(peer, model, rates, parsed.every)
    model.env.close()


if __name__ == "__main__":
    run(main, help_text(__doc__, PeersArguments))
