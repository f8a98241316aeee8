"""Relative orientation of all models of a flight, from table to table."""
