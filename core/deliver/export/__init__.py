"""Writers of patterns, meshes, the result folder and its report."""
