"""How a calculation runs: progress, clock, checkpoints, limited processes, records, errors; nothing of garments."""
