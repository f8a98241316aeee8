"""Heights of the ground that is flown over."""
