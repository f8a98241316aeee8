"""Sources of error, and what each step makes of them."""
