"""MJCF scenes: loaded, checked, and described as shapes and frames."""
