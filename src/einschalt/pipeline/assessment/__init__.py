"""What the measurements say of a result: findings, and the figure to believe."""
