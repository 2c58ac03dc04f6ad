"""From a scan and a body to the garment's surface with its open contours named."""
