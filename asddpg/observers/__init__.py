"""Who watches a run: metrics, progress bar, TensorBoard."""
