"""Before the flight: which precision to expect, and which flight to choose."""
