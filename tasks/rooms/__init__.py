"""Rooms made at run time: from files of other programs, or drawn by generators."""
