"""Programs a person runs on models, runs and recordings: `python -m tools.<name>`."""
