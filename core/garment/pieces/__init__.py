"""Production pieces: from a pattern of net panels to what is cut out of cloth."""
