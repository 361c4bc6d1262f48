"""XML of others: no document type, no entities, bounded in size, depth and number of elements."""

import math
from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from tasks.errors import TaskError
from tasks.rooms.limits import read_bytes

MAX_ELEMENTS = 500_000
MAX_DEPTH = 100
LARGEST = 1e6  # of a number, in any unit


def read_xml(path: Path, roots: tuple[str, ...]) -> Element:
    """The root of an XML file.

    Args:
        path: of the file.
        roots: names that the root may have.

    Raises:
        TaskError: as read_bytes, or the file is no XML of such a root, or beyond the limits.
    """
    data = read_bytes(path)
    try:
        root = _parse(data)
    except (expat.ExpatError, LookupError, ValueError) as error:
        raise TaskError(f"the file {path} cannot be read as XML: {error}") from error
    if root.tag not in roots:
        expected = " or ".join(f"<{name}>" for name in roots)
        raise TaskError(f"the file {path} begins with <{root.tag[:40]}>, but {expected} is expected")
    return root


def _parse(data: bytes) -> Element:
    builder = TreeBuilder()
    depth = count = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth, count
        depth, count = depth + 1, count + 1
        if depth > MAX_DEPTH or count > MAX_ELEMENTS:
            raise TaskError(f"it has more than {MAX_ELEMENTS:,} elements, or more than {MAX_DEPTH} inside one another")
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def refuse(*_: object) -> None:
        raise TaskError("it has a document type (<!DOCTYPE …>), which is refused")

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = builder.data, refuse
    parser.Parse(data, True)
    return builder.close()


def parse_numbers(text: str | None, count: int, what: str) -> list[float]:
    """Numbers from the text of an element or attribute.

    Args:
        text: numbers with white space between them.
        count: how many there must be.
        what: they are, for the message.

    Raises:
        TaskError: there are others, or one is not finite or larger than LARGEST.
    """
    words = (text or "").split(None, count)
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(abs(number) <= LARGEST for number in numbers):
        wanted = "a number" if count == 1 else f"{count} numbers"
        raise TaskError(f"{what} is {shorten(text or '')!r}, but must be {wanted} of at most {LARGEST:,.0f}")
    return numbers


def parse_sizes(text: str | None, count: int, what: str) -> list[float]:
    """As parse_numbers; TaskError also if one is not above 0."""
    numbers = parse_numbers(text, count, what)
    if not all(number > 0 and math.isfinite(1 / number) for number in numbers):
        raise TaskError(f"{what} is {shorten(text or '')!r}, but must be above 0")
    return numbers


def shorten(text: str) -> str:
    """A text from a file, in one line of at most 60 characters."""
    line = " ".join(text[:200].split())
    return line if len(line) <= 60 else f"{line[:59]}…"
