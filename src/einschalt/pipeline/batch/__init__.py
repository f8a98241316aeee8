"""Many blocks: the engines that run them, and the tables of the outcome."""
