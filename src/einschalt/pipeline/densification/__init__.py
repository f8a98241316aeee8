"""The ways to densified coordinates: two steps, or all models at once."""
