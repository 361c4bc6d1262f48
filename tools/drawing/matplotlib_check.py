"""Whether there is what plots need, told before the work that they are to show."""

from asddpg.errors import UserError


def check_matplotlib() -> None:
    """UserError where matplotlib is not installed."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise UserError("plots need matplotlib, which is not installed: pip install matplotlib") from error
