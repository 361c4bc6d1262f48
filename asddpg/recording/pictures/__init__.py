"""Camera pictures of recordings, and films."""
