"""What stands in the way of a plan, and what would help, with numbers."""
