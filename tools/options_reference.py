"""The options of all programs as Markdown, from their declarations: `python -m tools.options_reference`."""

import importlib
from collections.abc import Sequence

from asddpg.command_line import GROUPS
from asddpg.config import TrainConfig
from asddpg.options.help_text import help_text, markdown
from asddpg.options.parsing import NoArguments, parse_arguments
from asddpg.program import run

# Each program, and the dataclass of its arguments in that module.
PROGRAMS = {
    "asddpg.train": "TrainConfig",
    "asddpg.evaluate": "EvaluateConfig",
    "asddpg.play": "PlayConfig",
    "asddpg.mission": "MissionConfig",
    "asddpg.reproduce": "ReproduceArguments",
    "tools.episodes": "EpisodesArguments",
    "tools.replay_episode": "ReplayArguments",
    "tools.recover": "RecoverArguments",
    "tools.episode_frame": "FrameArguments",
    "tools.contact_sheet": "SheetArguments",
    "tools.episode_map": "MapArguments",
    "tools.episode_plot": "PlotArguments",
    "tools.diagnose": "DiagnoseArguments",
    "tools.publish": "PublishArguments",
    "tools.export": "ExportArguments",
    "tools.ablation": "AblationArguments",
    "tools.results": "ResultsArguments",
    "tools.room": "RoomArguments",
    "tools.picture": "PictureArguments",
    "tools.teleop": "TeleopArguments",
    "tools.robot_figures": "RobotFiguresArguments",
    "tools.bench": "BenchArguments",
    "tools.compare": "CompareArguments",
    "tools.localization": "LocalizationArguments",
    "tools.benchmarks.compare_peers": "PeersArguments",
    "tools.check_models": "NoArguments",
    "tools.draw_held_out": "NoArguments",
    "tools.options_reference": "NoArguments",
}


def declaration(program: str) -> tuple[str, type]:
    """What a program does, and the dataclass of its arguments."""
    module = importlib.import_module(program)  # a program is imported by no module; its declaration is read here
    kind: type = getattr(module, PROGRAMS[program])
    return str(module.__doc__), kind


def options_reference() -> str:
    """All programs and their options, a section each, as Markdown without a title."""
    sections = []
    for program in PROGRAMS:
        doc, kind = declaration(program)
        choices = GROUPS if kind is TrainConfig else None
        sections.append(f"## `{program}`\n\n{markdown(doc, kind, choices)}\n")
    return "\n".join(sections)


def main(arguments: Sequence[str]) -> None:
    """Print it."""
    parse_arguments(NoArguments, arguments)
    print(options_reference())


if __name__ == "__main__":
    run(main, help_text(__doc__, NoArguments))
