"""garmentq: a 3D scan of a garment goes in, a sewing pattern, a simulation mesh and a detailed mesh come out."""

__version__ = "0.1.0"
