"""Complete a recording that was interrupted or damaged: `python -m tools.recover runs/mine/episodes/….mcap.part`.

The steps that are whole in it become a complete file beside it. The old file stays, and nothing is overwritten.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.recording.files.recording_file import MCAP
from asddpg.recording.files.recovery import recover
from tasks.options import Range, argument


@dataclass(frozen=True)
class RecoverArguments:
    """The recording to complete."""

    file: Path = argument("The .mcap.part that a killed process left, or a damaged .mcap.")
    target: Path | None = argument(
        "The new file; without one <name>_cut.mcap.",
        None,
        Range(lambda path: path.suffix == MCAP, "a path that ends in .mcap"),
    )


def main(arguments: Sequence[str]) -> None:
    """Recover, and say what."""
    parsed = parse_arguments(RecoverArguments, arguments)
    episode, path = recover(parsed.file, parsed.target)
    print(f"{episode.steps} steps saved, {episode.outcome}, in {path}")


if __name__ == "__main__":
    run(main, help_text(__doc__, RecoverArguments))
