"""The precision of a planned block, by propagation on its layout."""
