"""From the colours of a scan to a texture on a garment's flat panels."""
