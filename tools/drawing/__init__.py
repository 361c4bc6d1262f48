"""Plots and maps: one style."""
