"""Offscreen pictures, and the graphics library they need."""
