"""From an untrusted file to a checked `Scan`."""
