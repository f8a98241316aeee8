"""All models of all flights in one adjustment, tables in and out."""
