"""One file format per module, reading and writing together."""
