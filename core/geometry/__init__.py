"""Triangle meshes and curves: what every room asks of them, without knowledge of cloth or bodies."""
