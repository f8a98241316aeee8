"""How models fit what they were fitted onto: residuals, and what explains them."""
