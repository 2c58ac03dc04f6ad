"""Cloth in motion: a garment on a wearer who moves."""
