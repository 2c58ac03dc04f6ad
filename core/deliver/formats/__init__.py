"""Writers of production formats: what is cut, printed or read by other cutting programs."""
