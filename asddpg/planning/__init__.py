"""Maps, planners and localisation, in NumPy: they know neither the simulator nor the networks."""
