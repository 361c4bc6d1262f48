"""The robot's model, measured and driven by hand."""
