"""The one exception for a user's mistake."""


class UserError(Exception):
    """One sentence on what is wrong and what would be right; the programs print it and exit with status 2."""
