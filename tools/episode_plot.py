"""A recorded episode's signals over time: `python -m tools.episode_plot FILE`.

Speeds commanded and driven, distance to the goal, what the critic said, reward by its terms, exploration noise, and in
the background who drove; what the recording does not hold is left out. Options:

  file=here.png      where the plot goes; <recording>_plot.png by itself
"""

from collections.abc import Sequence

from asddpg.program import run
from tools.drawing.matplotlib_check import check_matplotlib
from tools.drawing.picture_file import picture_file
from tools.recordings.arguments import single
from tools.recordings.episode_signals import read_signals


def main(arguments: Sequence[str]) -> None:
    """Read, draw, write."""
    recording, options = single(arguments, ("file",))
    file = picture_file(options.get("file", f"{recording.path.stem}_plot.png"), (".png",))
    check_matplotlib()
    signals = read_signals(recording)
    from tools.recordings.signal_drawing import draw_signals  # only here: -h and wrong words need no matplotlib

    draw_signals(signals, file)
    print(f"written to {file}")


if __name__ == "__main__":
    run(main, str(__doc__))
