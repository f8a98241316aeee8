"""What is measured under names of other points, beyond a pair in one model."""
