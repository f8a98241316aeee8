"""Transformations that are linear in each triangle of a net of identical points."""
