"""Recover pattern, fabric and meshes from a garment's scan: one immutable state, and the steps that improve it."""
