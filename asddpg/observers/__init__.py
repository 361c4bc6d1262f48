"""Observers of a run: metrics, step log, progress bar, TensorBoard."""
