"""Sewing patterns: panels, seams, control points, meshing and sewing."""
