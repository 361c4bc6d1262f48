"""See again what broke a training: `python -m asddpg.reproduce runs/<run>/breakdown_<step>`.

From the checkpoint in the folder the same steps are made again, to the one that broke. Nothing is written.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import SupportsFloat

from asddpg.build import check_device, make_agent, make_environment, prepare_torch
from asddpg.episodes.protocols import Callback, Step
from asddpg.errors import Breakdown, UserError
from asddpg.observers.finite_check import FiniteCheck
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.runs import failure_dump
from asddpg.runs.checkpoints import TrainingStates
from asddpg.runs.resumable import ResumableEpisodes
from asddpg.runs.run_folder import RunFolder, read_training
from asddpg.runs.safe_loading import OURS, check_links
from asddpg.training import validate
from tasks.options import argument, option


@dataclass(frozen=True)
class ReproduceArguments:
    """What is reproduced."""

    folder: Path = argument("Folder of the breakdown, runs/<run>/breakdown_<step>.")
    controller: str = option(
        OURS, "Controller of your own that the run was trained with: that you trust its code.", name="controller.type"
    )


def main(arguments: Sequence[str]) -> None:
    """Drive to the step that broke, and print what broke."""
    parsed = parse_arguments(ReproduceArguments, arguments)
    dump = parsed.folder
    check_links(dump)
    trouble = _read(dump)
    config, _ = read_training(RunFolder(dump).config, parsed.controller)
    check_device(config.device)
    prepare_torch()
    environment = make_environment(config.task, config.reward)
    agent = make_agent(config, environment)
    episodes = ResumableEpisodes(environment, agent, config.seed, print)
    state, _ = TrainingStates(RunFolder(dump).training_states).newest(lambda _: None)
    if state is not None:
        episodes.load_state(state["episodes"])
    last = LastStep()
    print(f"it was: after step {trouble.step} {trouble.what}\ndriving from step {episodes.step}", flush=True)
    end = trouble.step if trouble.in_validation else trouble.step + 1
    try:
        while episodes.step < min(end, config.total_steps):
            most = config.total_steps - episodes.steps  # as in the training: its last episode is cut there
            episodes.drive_episode([last, FiniteCheck(), _WeightsCheck(episodes, trouble.step)], max_steps=most)
        if trouble.in_validation:
            validate(make_environment(config.task, config.reward), agent, config)
    except failure_dump.CAUSES as error:
        print(f"again: after step {episodes.step} {failure_dump.first_line(error)}\n{last.as_text()}")
        return
    raise Breakdown(f"step {trouble.step} has passed, and nothing broke: another machine, or other versions")


def _read(dump: Path) -> failure_dump.Trouble:
    try:
        return failure_dump.read(dump)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"{dump} is not the folder of a breakdown: no {failure_dump.WHAT} can be read there") from error


class _WeightsCheck(Callback):
    """Watches, and looks at the weights after the step that broke, as the training did when it wrote a checkpoint."""

    def __init__(self, episodes: ResumableEpisodes, step: int) -> None:
        self._episodes, self._step = episodes, step

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Look at them, if it is the step."""
        if self._episodes.step == self._step:
            self._episodes.check_weights()


class LastStep(Callback):
    """Watches, and keeps the last step that was finished."""

    def __init__(self) -> None:
        self._seen: tuple[Step, Mapping[str, SupportsFloat]] | None = None

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Keep it."""
        self._seen = (step, learned)

    def as_text(self) -> str:
        """What it was."""
        if self._seen is None:
            return "no step was finished before"
        step, learned = self._seen
        metrics = {name: f"{float(value):.6g}" for name, value in learned.items()}
        lines = {
            "driver": step.decision.driver,
            "action": step.decision.action.tolist(),
            "pose": step.info.get("pose"),
            "reward terms": step.info.get("reward_terms"),
            "observation": step.next_observation.tolist(),
            "learned": metrics,
        }
        return "\n".join(f"  {name}: {value}" for name, value in lines.items())


if __name__ == "__main__":
    run(main, help_text(__doc__, ReproduceArguments))
