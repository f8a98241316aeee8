"""What photographs say of their measurements."""
