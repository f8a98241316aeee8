"""Fuzzing of every reader: hostile inputs must end in a result or a clear message."""
