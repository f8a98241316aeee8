"""Floor 0: errors, units, tables and linear algebra; knows no photogrammetry."""
