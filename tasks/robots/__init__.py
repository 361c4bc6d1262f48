"""Robots by name or file: read, put into a scene in place of the Pioneer, and checked by a short drive."""
