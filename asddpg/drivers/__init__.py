"""Drivers for the programs: a run, a baseline, a planner, and their robots."""
