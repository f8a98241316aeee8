"""Transformations as files that PROJ, and all that is built on it, can use."""
