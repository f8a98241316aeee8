"""Files of other programs: what is handed over to them, and what they measured."""
