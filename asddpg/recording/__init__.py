"""Recordings and the live view of episodes, in Foxglove's messages."""
