"""Least squares and what follows from it, whatever is adjusted."""
