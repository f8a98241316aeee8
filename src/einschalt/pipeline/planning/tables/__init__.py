"""Tables of precision before a flight, after the formula of 1971."""
