"""Running a calculation: progress, clock, checkpoints, limited processes, records, errors; without garments."""
