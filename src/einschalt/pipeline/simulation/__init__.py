"""Blocks with known truth."""
