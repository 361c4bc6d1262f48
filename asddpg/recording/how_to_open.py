"""What a user is told of opening recordings and live views in Foxglove."""

from pathlib import Path

LAYOUT = Path(__file__).resolve().parents[2] / "tools" / "foxglove" / "asddpg.layout.json"
_WITH_LAYOUT = f"once, for the layout: Layouts, Import from file, {LAYOUT}"


def how_to_open(files: int, folder: Path) -> str:
    """Of recordings in a folder."""
    what = "1 episode" if files == 1 else f"{files} episodes"
    return f"{what} recorded in {folder}; in Foxglove: Open local file; {_WITH_LAYOUT}"


def how_to_watch(port: int) -> str:
    """Of a live view."""
    return f"live: in Foxglove, Open connection, Foxglove WebSocket, ws://localhost:{port}; {_WITH_LAYOUT}"
