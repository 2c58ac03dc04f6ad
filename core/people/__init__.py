"""Label a dressed person's raw scan: find the wearer, and the part of every point."""
