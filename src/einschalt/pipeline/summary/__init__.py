"""The text of a result. Nothing is computed or decided here."""
