"""Where does the actor of a run fail? `python -m tools.diagnose run=runs/mine`.

Drives the stored validation pairs with each snapshot of the run: the actor alone, the switched policy, and once the
controller alone. Writes diagnosis.json and plots into the run's folder, under diagnosis/; docs/guides/diagnosis.md says
how to read them.
"""

from collections.abc import Sequence
from dataclasses import MISSING, dataclass
from pathlib import Path

from asddpg.algorithm.agent import AsDDPG
from asddpg.build import make_agent, make_environment, navigation_env, prepare_torch
from asddpg.errors import UserError, import_extra
from asddpg.messages import print_line
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.runs import weights_file
from asddpg.runs.loading import PREFIX
from asddpg.runs.lock import RunLock
from asddpg.runs.provenance import environment_hash
from asddpg.runs.run_folder import RunFolder, open_run_folder, read_training, write_json
from asddpg.runs.safe_loading import OURS
from tasks.evaluation_pairs import stored_pairs
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.options import between, option
from tasks.room_geometry.obstacles import Obstacles
from tools.diagnosis.run_diagnosis import Examiner, to_json
from tools.diagnosis.training_metrics import read_training_metrics


@dataclass(frozen=True)
class DiagnoseArguments:
    """The run to diagnose, and how thoroughly."""

    run: str = option(MISSING, "Folder of a training run, finished or in progress.")
    every: int = option(1, "1 takes every snapshot, 2 every second one, counted from the last.", between(1, 10_000))
    episodes: int = option(50, "Stored validation pairs driven.", between(1, 50))
    controller: str = option(
        OURS, "Controller of your own that the run was trained with: that you trust its code.", name="controller.type"
    )


@prepare_torch()
def main(arguments: Sequence[str]) -> None:
    """Drive, compute metrics, write, draw."""
    parsed = parse_arguments(DiagnoseArguments, arguments)
    if parsed.run.startswith(PREFIX):
        raise UserError(f"diagnose needs the folder of a training run, with its logs; {parsed.run} has none")
    folder = open_run_folder(parsed.run)
    config, provenance = read_training(folder.config, parsed.controller)
    config.device = "cpu"
    import_extra("matplotlib", "plots", "plots")  # before the driving, which takes minutes
    environment = make_environment(config.task, config.reward)
    agent = make_agent(config, environment, next(iter(folder.snapshots()), None))
    weights = list_weights(folder, agent, parsed.every)
    if environment_hash(environment) != provenance.get("model_hash"):
        print_line("note: the scene's model is not the one this run was trained on")
    has_steps = folder.steps.is_file()
    if agent.controller and not has_steps:
        print_line(f"note: there is no {folder.steps}, so the switch's preference in training is unknown")
    # Before the driving, which takes minutes: damaged logs stop it here.
    training = read_training_metrics(folder.metrics, folder.steps if agent.controller and has_steps else None)
    task = config.task
    pairs = stored_pairs(task.name, "validation", task.goal_radius, robot=task.robot)[: parsed.episodes]
    folder.diagnosis.mkdir(exist_ok=True)
    examiner = Examiner(str(folder.path), config, agent, environment, pairs, training)
    with RunLock(folder.diagnosis):
        for path in weights:
            snapshot = examiner.examine_snapshot(_load(path, agent))
            drivers = {"actor alone": snapshot.actor, "switched policy": snapshot.switched}
            rates = [f"{name} {metrics.success_rate.value:.2f}" for name, metrics in drivers.items() if metrics]
            print_line(f"step {snapshot.step}: success rate {', '.join(rates)}")
        write_json(folder.diagnosis / "diagnosis.json", to_json(examiner.diagnosis))
        from tools.diagnosis.plots import draw  # only here: --help needs no matplotlib

        draw(examiner.diagnosis, _mapped_obstacles(navigation_env(environment)), examiner.by_actor, folder.diagnosis)
    print_line(f"written to {folder.diagnosis}")


def _mapped_obstacles(environment: NavigationEnv) -> Obstacles:
    """Of the room; none where each episode has another, whose places lie over one another on the map."""
    return environment.obstacles if environment.task.room is None else Obstacles((), (-10.0, -10.0), (10.0, 10.0))


def list_weights(folder: RunFolder, agent: AsDDPG, every: int) -> list[Path]:
    """The weights to diagnose, oldest first: the snapshots, and the last checkpoint if it is newer.

    `every` takes each second, third … of them, counted from the last; the agent loads weights, to find which are newer.

    Raises:
        UserError: there are none, or the newest are damaged.
    """
    snapshots, last = folder.snapshots(), folder.checkpoint("last")
    if not snapshots and not last.is_file():
        raise UserError(f"{folder.path} has neither snapshots nor a last checkpoint: let it train up to a validation")
    if not snapshots:
        print_line("note: the run kept no snapshots (validation.snapshots, validation.every); only its end is driven")
        return [last]
    if last.is_file() and _load(last, agent) > _load(snapshots[-1], agent):
        snapshots.append(last)
    return snapshots[::-1][::every][::-1]


def _load(path: Path, agent: AsDDPG) -> int:
    return weights_file.load_into(path, agent.networks, needs_critic=True)


if __name__ == "__main__":
    run(main, help_text(__doc__, DiagnoseArguments))
