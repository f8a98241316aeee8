"""Floor 3: the order of the stages, settings, simulation."""
