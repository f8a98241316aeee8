"""Precision that a flight will have, before anything is measured."""
