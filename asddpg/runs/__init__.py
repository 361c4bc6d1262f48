"""A run's folder: its files, checkpoints, the lock, and what is read back from it."""
