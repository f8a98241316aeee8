"""Residuals of control points, distributed to the points between them."""
