"""A recording that was cut off or damaged, completed: `python -m tools.recover runs/mine/episodes/….mcap.part`.

The steps that are whole in it become a complete file beside it. The old file stays, and nothing is overwritten.
"""

import contextlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from mcap.records import McapRecord

from asddpg.errors import UserError, truncated_repr
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.recording.files.journal_reading import in_full
from asddpg.recording.files.mcap_file import CONFIG, METADATA
from asddpg.recording.files.reading import DAMAGE, PART
from tasks.options import Range, argument
from tools.recordings.contents import Contents, contents_of, write_recording
from tools.recordings.cut_episode import CutEpisode, episode_in
from tools.recordings.salvage import salvage

MCAP = ".mcap"
OUTCOMES = ("reached", "crashed", "timeout", "cut")


@dataclass(frozen=True)
class RecoverArguments:
    """The recording to complete."""

    file: Path = argument("The .mcap.part that a killed process left, or a damaged .mcap.")
    target: Path | None = argument(
        "The new file; without one <name>_cut.mcap.",
        None,
        Range(lambda path: path.suffix == MCAP, "a path that ends in .mcap"),
    )


def recover(source: Path, target: Path | None = None) -> tuple[CutEpisode, Path]:
    """Complete a recording; what was saved, and where it lies.

    Args:
        source: what is left of it.
        target: the new file; None names it after the old one and the outcome.

    Raises:
        UserError: the file is missing, whole, of another program, or holds no whole step; or the new one exists, or
            cannot be written.
    """
    episode = episode_in(_left_of(source), source.name)
    if episode is None:
        raise UserError(f"{source} holds no whole step, so there is nothing to recover")
    if target is None and episode.outcome not in OUTCOMES:
        raise UserError(
            f"{source} ended in {truncated_repr(episode.outcome)}, which is no outcome: name the new file besides"
        )
    target = target or _target(source, episode.outcome)
    if target.exists():
        raise UserError(f"{target} exists already; name another file: python -m tools.recover {source} <file.mcap>")
    write_recording(target, episode.contents)
    return episode, target


def _left_of(source: Path) -> Contents:
    try:
        found = salvage(source)
    except OSError as error:
        raise UserError(f"{source} cannot be read: {error.strerror}") from error
    contents = contents_of(_whole(in_full(found.records)))
    is_ours = METADATA in (each.name for each in contents.metadata)
    if not is_ours and (contents.messages or not found.damage):
        raise UserError(f"{source} is a recording of another program: it does not begin with {METADATA}")
    if not is_ours or CONFIG not in (each.name for each in contents.attachments):
        raise UserError(f"nothing of {source} can be recovered, its beginning is not whole ({found.damage})")
    if not found.damage and source.suffix != PART:
        raise UserError(f"{source} is whole, there is nothing to recover")
    return contents


def _whole(records: Iterable[McapRecord]) -> Iterator[McapRecord]:
    """All up to the first whose content is damaged."""
    with contextlib.suppress(*DAMAGE):
        yield from records


def _target(source: Path, outcome: str) -> Path:
    target = source.with_name(f"{_stem(source)}_{outcome}{MCAP}")
    # A file that is damaged after its outcome would get its own name.
    return target if target != source else source.with_name(f"{_stem(source)}_recovered_{outcome}{MCAP}")


def _stem(source: Path) -> str:
    """Its name without endings and outcome, which may be another now."""
    stem = source.name.removesuffix(PART).removesuffix(MCAP)
    for outcome in OUTCOMES:
        stem = stem.removesuffix(f"_{outcome}")
    return stem


def main(arguments: Sequence[str]) -> None:
    """Recover, and say what."""
    parsed = parse_arguments(RecoverArguments, arguments)
    episode, path = recover(parsed.file, parsed.target)
    print(f"{episode.steps} steps saved, {episode.outcome}, in {path}")


if __name__ == "__main__":
    run(main, help_text(__doc__, RecoverArguments))
