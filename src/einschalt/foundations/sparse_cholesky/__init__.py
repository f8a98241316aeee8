"""Sparse symmetric systems: ordering, factorization, solution, selected inverse."""
