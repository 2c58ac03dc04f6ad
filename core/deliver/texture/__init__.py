"""Textures on a garment's flat panels from the colours of a scan."""
