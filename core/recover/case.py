"""Define the inputs of one recovery, before a base pattern is chosen."""

from __future__ import annotations

from dataclasses import dataclass

from ..body.body import Body
from ..people.undeclared import UndeclaredGarment
from ..scan.contours.target import TOP_CATEGORIES, Target
from ..scan.scan import Scan
from .drape.wearer import WearerGeometry
from .recovery import Request
from .settings import RecoverySettings


@dataclass(frozen=True)
class Case:
    """Describe what is known of a garment after its contours were named; no step changes it.

    Attributes:
        request: The files and settings.
        scan: The checked scan.
        scan_target: The garment's surface as the scan shows it, with named contours: the reference of all measurements.
        wearer: The body with its distance fields.
        undeclared: Garments that the labels of a dressed person's scan mark as skin; None where there are no labels.
    """

    request: Request
    scan: Scan
    scan_target: Target
    wearer: WearerGeometry
    undeclared: tuple[UndeclaredGarment, ...] | None = None

    @property
    def settings(self) -> RecoverySettings:
        """Return the request's settings."""
        return self.request.settings

    @property
    def body(self) -> Body:
        """Return the wearer's body as it was found."""
        return self.wearer.body

    @property
    def has_free_curves(self) -> bool:
        """Return whether the scan may shape the base pattern's curves: not for pattern files or locked panels."""
        return self.request.template is None and not self.has_locked_panels

    @property
    def has_far_seams(self) -> bool:
        """Return whether seams may start too far from their place to reach it by small steps: library cuts and tops."""
        return self.has_free_curves or (self.scan_target.category in TOP_CATEGORIES and not self.has_locked_panels)

    @property
    def has_locked_panels(self) -> bool:
        """Return whether the user locks panels or points of them."""
        return any(word.startswith(("panel:", "point:")) for word in self.settings.locks)
