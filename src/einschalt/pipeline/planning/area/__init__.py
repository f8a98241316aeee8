"""A flight plan over an area: strips, photographs and control, and their precision."""
