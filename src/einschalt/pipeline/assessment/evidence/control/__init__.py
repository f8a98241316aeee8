"""Control that is wrong together, and heights of known points."""
