"""Races against the peers: ``python -m benchmarks [name …]``.

Every race runs all contenders in one process and in turn, five rounds or more after a
warm-up, and judges the median ratio against a floor; that all give the same result is
asserted in the same run. Absolute times depend on the machine and are for orientation.
"""
