"""The one exception for a user's mistake in what a task is asked for."""


class TaskError(ValueError):
    """What was asked for does not exist or is out of range; the message says what would be right."""
