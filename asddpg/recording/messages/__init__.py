"""Foxglove's messages: what each topic of a recording holds."""
