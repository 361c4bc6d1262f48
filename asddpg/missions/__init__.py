"""Missions: targets in turn, in a room whose map lacks obstacles, by a robot that localises itself."""
