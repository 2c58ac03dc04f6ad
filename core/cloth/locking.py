"""Reduce membrane locking: linear triangles of a coarse mesh make cloth too stiff."""

from __future__ import annotations

from dataclasses import replace

from .fabric import Fabric
from .settings import STANDARD_GRAVITY

MAX_COARSE_MESH_STRAIN = 0.01
"""Largest strain [1] of a metre of cloth under its own weight in a drape on a coarse mesh. The mean is half of it, less
than the 1 to 3 % by which scanned cloth is stretched; in return folds can form (`reduce_membrane_stiffness`)."""


def reduce_membrane_stiffness(fabric: Fabric) -> Fabric:
    """Return the fabric with a membrane so soft that linear triangles of 2 cm can still fold.

        H' = s H,    s = min(1, density g 1 m / (MAX_COARSE_MESH_STRAIN max(H00, H11)))

    A flat triangle of edge h on a fold of curvature kappa is strained by about (h kappa)^2 / 24. With h = 2 cm that is
    0.2 % on folds of 10 cm radius, whose energy at 1000 N/m is three times that of a poplin's bending, and 1.8 % on
    folds of 3 cm radius, with forty times that energy (membrane locking). A stiff membrane on a coarse mesh therefore
    hangs in a few wide folds, whatever k is. All membrane stiffnesses are scaled alike, which keeps the anisotropy.

    Notation: H the membrane stiffnesses, s `share`.

    **Deviation**: the thesis takes the fabric's own membrane.
    """
    weight = -STANDARD_GRAVITY[1]
    share = min(1.0, fabric.density * weight / (MAX_COARSE_MESH_STRAIN * max(fabric.H00, fabric.H11)))
    return replace(
        fabric, H00=share * fabric.H00, H01=share * fabric.H01, H11=share * fabric.H11, H22=share * fabric.H22
    )
