"""Name the open contours of a garment from its scan and its body."""
