"""Readers of flat rooms: maps, pictures, mazes of text, IR-SIM."""
