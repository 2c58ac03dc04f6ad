"""Dress other bodies in a recovered garment, as it is or made to measure."""
