"""Floor 4: files, reports, provenance, command line."""
