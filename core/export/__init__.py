"""Writers of patterns and meshes."""
