"""Transformations of models onto the ground: affine, helmert, rigid, helmert_3d."""
