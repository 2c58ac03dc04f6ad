"""Keep a coarse mesh from hanging stiffer than its cloth: linear triangles lock."""

from __future__ import annotations

from dataclasses import replace

from .fabric import Fabric
from .settings import STANDARD_GRAVITY

MAX_COARSE_MESH_STRAIN = 0.01
"""Largest strain of a metre of cloth under its own weight in a drape on a coarse mesh. It is half of that on average,
less than the 1 to 3 % by which scanned cloth is stretched; in return folds can form (`reduce_membrane_stiffness`)."""


def reduce_membrane_stiffness(fabric: Fabric) -> Fabric:
    """Return the fabric with a membrane so soft that linear triangles of 2 cm can still fold.

        H' = s H,    s = min(1, density g 1 m / (SAG max(H00, H11)))

    A flat triangle of edge h on a fold of curvature kappa is strained by about (h kappa)^2 / 24: with h = 2 cm by 0.2 %
    on folds of 10 cm radius, which costs 1000 N/m three times what a poplin's bending costs, and by 1.8 % on folds of
    3 cm radius, which costs forty times as much (membrane locking). A stiff membrane on a coarse mesh therefore hangs
    in a few wide folds, whatever k is. All membrane stiffnesses shrink alike, so anisotropy stays.

    Notation: H the membrane stiffnesses, s `share`.

    **Deviation**: the thesis takes the fabric's own membrane.
    """
    weight = -STANDARD_GRAVITY[1]
    share = min(1.0, fabric.density * weight / (MAX_COARSE_MESH_STRAIN * max(fabric.H00, fabric.H11)))
    return replace(
        fabric, H00=share * fabric.H00, H01=share * fabric.H01, H11=share * fabric.H11, H22=share * fabric.H22
    )
