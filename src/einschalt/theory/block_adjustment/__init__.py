"""All models of both flights at once: the simultaneous adjustment."""
