"""The sections of the summary and of the report, one module for each."""
