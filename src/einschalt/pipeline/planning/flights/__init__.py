"""What may be flown: cameras, two flights as designs, ranges of what is asked."""
