"""Episodes: protocols of the parts, the one loop, drivers, and evaluation."""
