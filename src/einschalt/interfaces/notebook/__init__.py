"""What a notebook shows of results, blocks and plans: figures, cards, frames."""
