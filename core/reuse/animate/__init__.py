"""Animation: a garment on a moving wearer."""
