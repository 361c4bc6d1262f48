"""A recorded episode's signals over time: `python -m tools.episode_plot FILE`.

Commanded and driven speeds, distance to the goal, Q values, reward by its terms, exploration noise, and the driver in
the background; signals that the recording lacks are left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from asddpg.errors import import_extra
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks.options import argument, option
from tools.drawing.picture_file import PNG_FILE
from tools.recordings.episode_signals import read_signals
from tools.recordings.files import open_single


@dataclass(frozen=True)
class PlotArguments:
    """The recording to plot."""

    recording: Path = argument("A recording, or a folder that holds one.")
    file: Path | None = option(None, "File of the plot; null names it <recording>_plot.png.", PNG_FILE)


def main(arguments: Sequence[str]) -> None:
    """Read, draw, write."""
    parsed = parse_arguments(PlotArguments, arguments)
    recording = open_single(parsed.recording)
    file = parsed.file or Path(f"{recording.path.stem}_plot.png")
    import_extra("matplotlib", "plots", "plots")
    signals = read_signals(recording)
    from tools.recordings.signal_drawing import draw_signals  # only here: -h and wrong arguments need no matplotlib

    draw_signals(signals, file)
    print(f"written to {file}")


if __name__ == "__main__":
    run(main, help_text(__doc__, PlotArguments))
