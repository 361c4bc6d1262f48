"""The live view in Foxglove, over a WebSocket."""
