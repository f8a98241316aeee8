"""Floor 1: the papers, arrays in and arrays out, one effect or author per file."""
