"""Mechanical parameters of a fabric."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Fabric", "FabricEstimate"]


@dataclass(frozen=True)
class Fabric:
    """Describe a fabric's mechanics (thesis eq. 3.3 and 3.4; index 0 is the weft, u; 1 the warp, v; 2 shear).

    Attributes:
        name: Stable name, `cotton_poplin`.
        H00: Membrane stiffness along u (weft) [N/m].
        H01: Coupling of u and v [N/m].
        H11: Membrane stiffness along v (warp) [N/m].
        H22: Shear stiffness [N/m].
        k: Bending stiffness [N m].
        density: Mass per area [kg/m2].
        thickness: Thickness [m].
        friction: Coulomb coefficient against skin.
        title: Name for display, `cotton poplin, 115 g/m2`.
        sources: For each parameter `measured: ...`, `derived: ...` or `assumed: ...`.
    """

    name: str
    H00: float
    H01: float
    H11: float
    H22: float
    k: float
    density: float
    thickness: float = 5e-4
    friction: float = 0.3
    title: str = ""
    sources: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class FabricEstimate:
    """Describe the estimate of one of a fabric's parameters from a drape.

    Attributes:
        name: One of H00, H01, H11, H22 [N/m], k [N m], density [kg/m2].
        value: Its value, at the assumed density.
        std: Posterior standard deviation of its logarithm.
        prior_std: The prior's.
        identifiable: True where the value was estimated from the drape, which narrows it to half of the prior.
        note: The same in words.
    """

    name: str
    value: float
    std: float
    prior_std: float
    identifiable: bool
    note: str
