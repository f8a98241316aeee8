"""Floor 3: a block densified, judged and told; simulation, planning, batches."""
