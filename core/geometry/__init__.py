"""Triangle meshes and curves, without knowledge of cloth or bodies."""
