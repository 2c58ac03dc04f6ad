"""One garment to recover: what its files say, before a base pattern is chosen."""

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
    """What is known of a garment after its contours were named; no step changes it.

    Attributes:
        request: The files and settings.
        scan: The checked scan.
        seen: The garment's surface as the scan shows it, contours named: what every result is measured against.
        wearer: The body with its distance fields.
        undeclared: Garments that the marks of a dressed person's scan leave to the skin; None where there are no marks.
    """

    request: Request
    scan: Scan
    seen: Target
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
        """Return whether the scan may shape the base pattern's curves: not those of a file, or of what is locked."""
        return self.request.template is None and not self.has_locked_panels

    @property
    def has_far_seams(self) -> bool:
        """Return whether seams may begin too far from where the cloth has them to creep there.

        So do those of the library's cuts, and those of a maker's top, which is graded in the stretch of its dressing.
        """
        return self.has_free_curves or (self.seen.category in TOP_CATEGORIES and not self.has_locked_panels)

    @property
    def has_locked_panels(self) -> bool:
        """Return whether the user locks panels or points of them."""
        return any(word.startswith(("panel:", "point:")) for word in self.settings.locks)
