"""Batches: many block folders to many result folders, on one engine."""
