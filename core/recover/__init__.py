"""From a garment's scan to its pattern, fabric and meshes: one value that steps improve, and the steps."""
