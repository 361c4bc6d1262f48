"""Recordings and the live view: what watches episodes and tells Foxglove."""
