"""The one exception for an argument that no task can use."""


class TaskError(ValueError):
    """A name that does not exist or a value out of range; the message says what is valid."""
