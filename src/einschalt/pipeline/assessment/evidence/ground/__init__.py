"""What control is taken for: metres, axes, a map."""
