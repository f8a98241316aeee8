"""What each section of a summary shows, in numbers and names."""
