"""Control that is wrong together, heights of known points, and what wrong ones do."""
