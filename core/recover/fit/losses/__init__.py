"""Losses of the inverse fit: on positions, on control points and on the fabric, each with its gradient."""
