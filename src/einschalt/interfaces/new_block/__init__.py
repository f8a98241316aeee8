"""A first block.toml: what files hold, what follows from them, what must be asked."""
