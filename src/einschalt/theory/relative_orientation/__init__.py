"""Relative orientation, one author or effect per file."""
