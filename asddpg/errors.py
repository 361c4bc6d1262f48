"""The one exception for a user's mistake."""


class Breakdown(Exception):  # noqa: N818  # the field's word
    """A training met numbers that are none; the message says where, and how to see it again."""


class UserError(Exception):
    """One sentence on what is wrong and what would be right; the programs print it and exit with status 2."""
