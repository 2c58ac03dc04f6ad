"""Simulate cloth: compute the equilibrium of a sewn garment of a given fabric on a body."""
