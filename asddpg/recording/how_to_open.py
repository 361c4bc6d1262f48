"""Instructions for opening recordings and live views in Foxglove."""

from pathlib import Path

LAYOUT = Path(__file__).resolve().parents[2] / "tools" / "foxglove" / "asddpg.layout.json"
_WITH_LAYOUT = f"once, for the layout: Layouts, Import from file, {LAYOUT}"


def how_to_open(files: int, folder: Path) -> str:
    """Instructions for recordings in a folder."""
    episodes = "1 episode" if files == 1 else f"{files} episodes"
    return f"{episodes} recorded in {folder}; in Foxglove: Open local file; {_WITH_LAYOUT}"


def how_to_watch(port: int) -> str:
    """Instructions for a live view."""
    return f"live: in Foxglove, Open connection, Foxglove WebSocket, ws://localhost:{port}; {_WITH_LAYOUT}"
