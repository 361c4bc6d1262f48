"""Repeat the step at which a training failed: `python -m asddpg.reproduce runs/<run>/failure_<step>`.

From the training state in the folder the same steps are made again, up to the one that failed. Nothing is written.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from asddpg.algorithm.agent import AsDDPG
from asddpg.build import check_device, make_agent, make_training_robots, prepare_torch
from asddpg.config import TrainConfig
from asddpg.episodes.batch_steps import Steps
from asddpg.episodes.finite_check import check_weights
from asddpg.episodes.protocols import Step
from asddpg.episodes.training_episodes import Learned, TrainingEpisodes, TrainingObserver
from asddpg.errors import NumericalFailure
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.runs import failure_dump
from asddpg.runs.failure_dump import Failure, first_line
from asddpg.runs.run_folder import RunFolder, read_training
from asddpg.runs.safe_loading import OURS, check_links
from asddpg.runs.training_states import TrainingStates
from asddpg.training import load_episodes, make_validation_robots, validate
from tasks.options import argument, option


@dataclass(frozen=True)
class ReproduceArguments:
    """The failure to repeat."""

    folder: Path = argument("Folder of the failure, runs/<run>/failure_<step>.")
    controller: str = option(
        OURS, "Controller of your own that the run was trained with: that you trust its code.", name="controller.type"
    )


@prepare_torch()
def main(arguments: Sequence[str]) -> None:
    """Drive to the step that failed, and print it."""
    parsed = parse_arguments(ReproduceArguments, arguments)
    path = parsed.folder
    check_links(path)
    failure = failure_dump.read(path)
    config, _ = read_training(RunFolder(path).config, parsed.controller)
    check_device(config.device)
    robots = make_training_robots(config)
    agent = make_agent(config, robots.envs[0])
    episodes = TrainingEpisodes(robots, agent, config.seed)
    state, _ = TrainingStates(RunFolder(path).training_states).newest(lambda _: None)
    if state is not None:
        load_episodes(episodes, state)
    last = LastStep()
    episodes.observers.append(last)
    print(f"it was: after step {failure.step} {failure.message}\ndriving from step {episodes.step}", flush=True)
    try:
        _repeat(episodes, agent, config, failure)
    except failure_dump.CAUSES as error:
        print(f"again: after step {episodes.step} {first_line(error)}\n{last.as_text()}")
        return
    raise NumericalFailure(f"step {failure.step} has passed without a failure: another machine, or other versions")


def _repeat(episodes: TrainingEpisodes, agent: AsDDPG, config: TrainConfig, failure: Failure) -> None:
    while episodes.step < failure.step:
        episodes.drive_step(config.total_steps)
    check_weights(agent.learner.finite_weights())  # as before each training state
    if failure.in_validation:
        validate(make_validation_robots(config), agent.act, config)
    elif episodes.step < config.total_steps:
        episodes.drive_step(config.total_steps)  # a step that the simulator did not finish is not counted


class LastStep(TrainingObserver):
    """Keeps the last step that was finished."""

    def __init__(self) -> None:
        self._last: tuple[Steps, Learned] | None = None

    def step(self, steps: Steps, learned: Learned) -> None:
        """Keep the step."""
        self._last = (steps, learned)

    def as_text(self) -> str:
        """The step of each robot, a line a quantity, and what was learned in it."""
        if self._last is None:
            return "no step was finished before"
        steps, learned = self._last
        lines = [line for robot in range(len(steps.rewards)) for line in _lines(robot, steps.row(robot))]
        metrics = [{name: f"{float(value):.6g}" for name, value in update.items()} for update in learned]
        return "\n".join([*lines, f"  learned: {metrics}"])


def _lines(robot: int, step: Step) -> list[str]:
    values = {
        "robot": robot,
        "driver": step.decision.driver,
        "action": step.decision.action.tolist(),
        "pose": step.info.get("pose"),
        "reward terms": step.info.get("reward_terms"),
        "observation": step.next_observation.tolist(),
    }
    return [f"  {name}: {value}" for name, value in values.items()]


if __name__ == "__main__":
    run(main, help_text(__doc__, ReproduceArguments))
