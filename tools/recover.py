"""Completes a recording that was interrupted or damaged: `python -m tools.recover FILE [OUT.mcap]`.

FILE is the .mcap.part that a killed process leaves, or a damaged .mcap. The steps that are whole in it become a
complete file beside it, <name>_cut.mcap by itself; FILE stays, and nothing is overwritten.
"""

from collections.abc import Sequence
from pathlib import Path

from asddpg.errors import UserError
from asddpg.program import run
from asddpg.recording.files.recording_file import MCAP
from asddpg.recording.files.recovery import recover


def main(arguments: Sequence[str]) -> None:
    """Recover, and say what."""
    if not 1 <= len(arguments) <= 2:
        raise UserError("recover what? python -m tools.recover <file.mcap.part or damaged file.mcap> [<new file.mcap>]")
    target = Path(arguments[1]) if len(arguments) == 2 else None
    if target is not None and target.suffix != MCAP:
        raise UserError(f"the new file's name must end in {MCAP}, not {target.name!r}")
    episode, path = recover(Path(arguments[0]), target)
    print(f"{episode.steps} steps saved, {episode.outcome}, in {path}")


if __name__ == "__main__":
    run(main, str(__doc__))
