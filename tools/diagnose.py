"""Where does the actor of a run fail? `python -m tools.diagnose run=runs/mine`.

Drives the stored validation pairs with each snapshot of the run: the actor alone, the switched policy, and once the
controller alone. Writes diagnosis.json and plots into the run's folder, under diagnosis/; docs/guides/diagnosis.md says
how to read them. Options:

  run=runs/mine      folder of a training run, finished or in progress
  every=1            1 takes every snapshot, 2 every second one, counted from the last
  episodes=50        pairs driven, of the 50 stored
  controller.type=   of a run with a controller of its own, package.module:Factory: that you trust that code
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from asddpg.algorithm.agent import AsDDPG
from asddpg.build import make_agent, make_environment, prepare_torch
from asddpg.errors import UserError
from asddpg.program import run
from asddpg.runs import weights_file
from asddpg.runs.loading import PREFIX
from asddpg.runs.provenance import environment_hash
from asddpg.runs.run_folder import RunFolder, open_run_folder, read_training, write_json
from asddpg.runs.safe_loading import OURS
from tasks.evaluation_pairs import stored_pairs
from tasks.room_geometry.obstacles import Obstacles
from tools.diagnosis.run_diagnosis import Diagnosis, Examiner, Snapshot, to_json
from tools.diagnosis.training_metrics import read_training_metrics
from tools.drawing.matplotlib_check import check_matplotlib
from tools.option_arguments import options_in

CONTROLLER = "controller.type"
MAX_COUNTS = {"every": 10_000, "episodes": 50}


@dataclass(frozen=True)
class Wish:
    """What is to be diagnosed."""

    run: str
    every: int = 1
    episodes: int = 50
    controller: str = OURS


def wish(arguments: Sequence[str]) -> Wish:
    """Read the command line's words; UserError where one is wrong."""
    options = options_in(arguments, ("run", *MAX_COUNTS, CONTROLLER))
    if not options.get("run"):
        raise UserError("diagnose what? run=<run_dir>, the folder of a training run")
    if options["run"].startswith(PREFIX):
        raise UserError(f"diagnose needs the folder of a training run, with its logs; {options['run']} has none")
    numbers = {name: _number(name, options[name]) for name in MAX_COUNTS if name in options}
    return Wish(options["run"], **numbers, controller=options.get(CONTROLLER, OURS))


def _number(name: str, value: str) -> int:
    if not (value.isascii() and value.isdigit() and 1 <= int(value) <= MAX_COUNTS[name]):
        raise UserError(f"{name} must be a whole number from 1 to {MAX_COUNTS[name]}, not {value!r}")
    return int(value)


def main(arguments: Sequence[str]) -> None:
    """Drive, compute metrics, write, draw."""
    asked = wish(arguments)
    folder = open_run_folder(asked.run)
    config, provenance = read_training(folder.config, asked.controller)
    config.device = "cpu"
    check_matplotlib()  # before the driving, which takes minutes
    prepare_torch()
    environment = make_environment(config.task, config.reward)
    agent = make_agent(config, environment, next(iter(folder.snapshots()), None))
    weights = list_weights(folder, agent, asked.every)
    if environment_hash(environment) != provenance.get("model_hash"):
        print("note: the scene's model is not the one this run was trained on")
    has_steps = folder.steps.is_file()
    if agent.controller and not has_steps:
        print(f"note: there is no {folder.steps}, so the switch's preference in training is unknown")
    # Before the driving, which takes minutes: damaged logs stop it here.
    training = read_training_metrics(folder.metrics, folder.steps if agent.controller and has_steps else None)
    pairs = stored_pairs(config.task.name, "validation", config.task.goal_radius)[: asked.episodes]
    folder.diagnosis.mkdir(exist_ok=True)
    examiner = Examiner(config, environment, agent, pairs)
    snapshots = [_examine(examiner, agent, path) for path in weights]
    diagnosis = examiner.diagnosis(str(folder.path), snapshots, training)
    write_json(folder.diagnosis / "diagnosis.json", to_json(diagnosis))
    obstacles = Obstacles.from_model(environment.get_wrapper_attr("physics").model.ptr)
    _draw(diagnosis, obstacles, examiner, folder.diagnosis)
    print(f"written to {folder.diagnosis}")


def list_weights(folder: RunFolder, agent: AsDDPG, every: int) -> list[Path]:
    """The weights to diagnose, oldest first: the snapshots, and the last checkpoint if it is newer.

    Args:
        folder: of the run.
        agent: loads weights, to find which are newer.
        every: 2 for every second one, counted from the last.

    Raises:
        UserError: there are none, or the newest are damaged.
    """
    snapshots, last = folder.snapshots(), folder.checkpoint("last")
    if not snapshots and not last.is_file():
        raise UserError(f"{folder.path} has neither snapshots nor a last checkpoint: let it train up to a validation")
    if not snapshots:
        print("note: the run kept no snapshots (validation.snapshots, validation.every); only its end is driven")
        return [last]
    if last.is_file() and weights_file.load(last, agent) > weights_file.load(snapshots[-1], agent):
        snapshots.append(last)
    return snapshots[::-1][::every][::-1]


def _examine(examiner: Examiner, agent: AsDDPG, path: Path) -> Snapshot:
    snapshot = examiner.examine_snapshot(weights_file.load(path, agent))
    drivers = {"actor alone": snapshot.actor, "switched policy": snapshot.switched}
    rates = [f"{name} {metrics.success_rate.value:.2f}" for name, metrics in drivers.items() if metrics]
    print(f"step {snapshot.step}: success rate {', '.join(rates)}", flush=True)
    return snapshot


def _draw(diagnosis: Diagnosis, obstacles: Obstacles, examiner: Examiner, folder: Path) -> None:
    from tools.diagnosis.plots import draw  # only here: --help needs no matplotlib

    draw(diagnosis, obstacles, examiner.by_actor, folder)


if __name__ == "__main__":
    run(main, str(__doc__))
