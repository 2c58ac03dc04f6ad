"""Production pieces: from a pattern of net panels to pieces to be cut out of cloth."""
