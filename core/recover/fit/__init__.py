"""The inverse fit: the pattern from a registered garment, by its metric and through the simulator."""
