"""Judges: each looks at one thing and gives a finding, or None."""
