"""Fit the pattern to a registered garment, by its metric and through the simulator."""
