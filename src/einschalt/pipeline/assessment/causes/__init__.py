"""Causes: what explains other findings, and is told in their place."""
