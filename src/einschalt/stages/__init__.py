"""Floor 2: the five stages, tables in and one result out."""
