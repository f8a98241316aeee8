"""Problems, and what to do about each."""
