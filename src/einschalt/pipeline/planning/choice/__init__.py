"""The plan that keeps its target on its own layout, at the least cost."""
