"""Rooms drawn at random, without end."""
