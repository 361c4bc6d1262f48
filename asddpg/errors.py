"""What ends a program in one sentence."""

_LONGEST = 60  # characters of a value in a sentence


class Breakdown(Exception):  # noqa: N818  # the field's word
    """A training met numbers that are none; the message says where, and how to see it again."""


class UserError(Exception):
    """One sentence on what is wrong and what would be right; the programs print it and exit with status 2."""


def truncated_repr(value: object) -> str:
    """A value as a sentence shows it: text in quotes, cut where it is long."""
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 2]}…{text[-1]}"
