"""The words of a command line that are options: name=value."""

from collections.abc import Iterable, Sequence

from asddpg.errors import UserError


def options_in(arguments: Iterable[str], known: Sequence[str] = ()) -> dict[str, str]:
    """Options by name.

    Args:
        arguments: each name=value.
        known: the names there are; empty takes any.

    Raises:
        UserError: a word is no option, of another name, or given twice.
    """
    options: dict[str, str] = {}
    for argument in arguments:
        name, equals, value = argument.partition("=")
        if not equals:
            raise UserError(f"{argument!r} is not an option of the form name=value, such as run=runs/mine")
        if known and name not in known:
            raise UserError(f"there is no option {name!r}; there are {', '.join(known)}")
        if name in options:
            raise UserError(f"{name} is given twice, as {options[name]} and {value}")
        options[name] = value
    return options
