"""Plans estimated by closed formulas, what they take, and what would help."""
