"""PhyDeformer: a garment mesh deformed onto a target by per-triangle Jacobians (thesis chapter 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .deformation import Deformation
from .settings import DeformSettings, DeformSettingsBad

if TYPE_CHECKING:
    from .deformer import deform

__all__ = ["DeformSettings", "DeformSettingsBad", "Deformation", "deform"]


def __getattr__(name: str) -> Any:
    """Load the deformer, and torch with it, on first use."""
    if name == "deform":
        from .deformer import deform

        return deform
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return all names, that too which is loaded on first use."""
    return sorted({*globals(), *__all__})
