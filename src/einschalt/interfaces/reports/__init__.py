"""Reports and figures: made from results, never computing any."""
