"""What the measurements show beside the coordinates: computed, not yet judged."""
