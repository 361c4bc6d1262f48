"""Recordings as MCAP files, written and read."""
