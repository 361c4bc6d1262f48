"""Completes recordings that were interrupted or damaged: whole steps become a complete file."""

import contextlib
from pathlib import Path

from asddpg.errors import UserError, truncated_repr
from asddpg.recording.files.contents import Contents, read_contents, write_contents
from asddpg.recording.files.cut_episode import CUT, CutEpisode, end_episode
from asddpg.recording.files.reading import DAMAGE
from asddpg.recording.files.recording_file import CONFIG, MCAP, METADATA, PART

OUTCOMES = ("reached", "crashed", "timeout", CUT)


def recover(source: Path, target: Path | None = None) -> tuple[CutEpisode, Path]:
    """Complete a recording; returns what was saved, and its file.

    Args:
        source: the rest of the recording, which stays.
        target: the new file; None names it after the old one and the outcome.

    Raises:
        UserError: the file is missing, whole, of another program, or holds no whole step; or the new one exists, or
            cannot be written.
    """
    episode = end_episode(_read_rest(source), source.name)
    if episode is None:
        raise UserError(f"{source} holds no whole step, so there is nothing to recover")
    if target is None and episode.outcome not in OUTCOMES:
        raise UserError(
            f"{source} ended in {truncated_repr(episode.outcome)}, which is no outcome: give the new file a name"
        )
    target = target or _name_target(source, episode.outcome)
    if target.exists():
        raise UserError(f"{target} exists already; name another file: python -m tools.recover {source} <file.mcap>")
    write_contents(target, episode.contents)
    return episode, target


def complete_interrupted(part: Path) -> Path | None:
    """Complete the recording that a killed process left, and delete the part.

    Args:
        part: `<stem>.mcap.part`; one that cannot be completed, as on a full disk, stays.

    Returns:
        `<stem>_cut.mcap`; or the complete recording of that stem, if the process was killed before it deleted the part;
        None where no step is whole, or nothing could be written.
    """
    path = next(part.parent.glob(f"{_stem(part)}_*{MCAP}"), None)
    if path is None:
        try:
            episode = end_episode(_read_rest(part), part.name)
        except (UserError, *DAMAGE):
            episode = None
        if episode is not None:
            path = part.with_name(f"{_stem(part)}_{CUT}{MCAP}")
            try:
                write_contents(path, episode.contents)
            except UserError:
                return None
    with contextlib.suppress(OSError):
        part.unlink()
    return path


def _read_rest(source: Path) -> Contents:
    try:
        contents = read_contents(source)
    except OSError as error:
        raise UserError(f"{source} cannot be read: {error.strerror}") from error
    is_ours = METADATA in (each.name for each in contents.metadata)
    if not is_ours and (contents.messages or not contents.damage):
        raise UserError(f"{source} is a recording of another program: it does not begin with {METADATA}")
    if not is_ours or CONFIG not in (each.name for each in contents.attachments):
        raise UserError(f"nothing of {source} can be recovered, its beginning is not whole ({contents.damage})")
    if not contents.damage and source.suffix != PART:
        raise UserError(f"{source} is whole, there is nothing to recover")
    return contents


def _name_target(source: Path, outcome: str) -> Path:
    target = source.with_name(f"{_stem(source)}_{outcome}{MCAP}")
    # A file that is damaged after its outcome would get its own name.
    return target if target != source else source.with_name(f"{_stem(source)}_recovered_{outcome}{MCAP}")


def _stem(source: Path) -> str:
    """Its name without endings and outcome."""
    stem = source.name.removesuffix(PART).removesuffix(MCAP)
    for outcome in OUTCOMES:
        stem = stem.removesuffix(f"_{outcome}")
    return stem
