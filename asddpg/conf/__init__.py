"""Hydra's YAML files: only what differs from the defaults in asddpg/config.py."""
