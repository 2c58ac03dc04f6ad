"""Read an untrusted file and return a checked `Scan`."""
