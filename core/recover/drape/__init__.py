"""The first drape: from a flat pattern to a garment that hangs on a body in any pose."""
