"""One garment to recover: what is known before the first drape, and the graded drape that every method starts from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..scan.contours import TOPS
from .recovery import Request
from .settings import RecoverySettings

if TYPE_CHECKING:
    import numpy as np

    from ..body import Body
    from ..cloth import Drape, Fabric
    from ..garment import Garment, Pattern
    from ..people.undeclared import Undeclared
    from ..scan import Scan
    from ..scan.contours import Target
    from .drape import WearerGeometry
    from .grade import Candidate, PanelChange


@dataclass(frozen=True)
class Case:
    """What is known of a garment after segmentation; no later stage changes it.

    Attributes:
        request: The files and settings.
        scan: The checked scan.
        wearer: The body with its distance fields.
        target: The garment's surface with named contours, completed where another garment hides it: what every fit
            has to reach.
        template: Name of the base pattern.
        base: The base pattern: gives symmetry, proportions and gathered seams.
        fabric: The cloth to begin with.
        scanned: The target as the scan shows it, where it was completed; None where it is the target.
        candidates: The cuts that the scan's contours are nearest to, the base pattern first; empty where it was named.
        notes: What the user should know of the base pattern, one sentence each.
        undeclared: Garments that the marks of a dressed person's scan leave to the skin; None where there are no marks.
    """

    request: Request
    scan: Scan
    wearer: WearerGeometry
    target: Target
    template: str
    base: Pattern
    fabric: Fabric
    scanned: Target | None = None
    candidates: tuple[Candidate, ...] = ()
    notes: tuple[str, ...] = ()
    undeclared: tuple[Undeclared, ...] | None = None

    @property
    def seen(self) -> Target:
        """Return the target as the scan shows it: what every result is measured against."""
        return self.target if self.scanned is None else self.scanned

    @property
    def settings(self) -> RecoverySettings:
        """Return the request's settings."""
        return self.request.settings

    @property
    def body(self) -> Body:
        """Return the wearer's body."""
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
        return self.has_free_curves or (self.target.category in TOPS and not self.has_locked_panels)

    @property
    def has_locked_panels(self) -> bool:
        """Return whether the user locks panels or points of them."""
        return any(word.startswith(("panel:", "point:")) for word in self.settings.locks)


@dataclass(frozen=True)
class GradedDrape:
    """The graded pattern on the wearer.

    Attributes:
        garment: Its mesh, nodes at rest outside the wearer, contours named.
        drape: The equilibrium as the solver left it.
        warnings: What the user should know, one sentence each.
        laid: The nodes on the target, where the sliding of a pattern with free curves left them [m], shape
            [node_count, 3]; None for others, and where hanging arms hide so much cloth that layers of it would lie in
            each other.
        base: The base pattern with the darts that the scan has shown; None: the case's.
        changes: These darts.
    """

    garment: Garment
    drape: Drape
    warnings: tuple[str, ...] = ()
    laid: np.ndarray | None = None
    base: Pattern | None = None
    changes: tuple[PanelChange, ...] = ()

    @property
    def starts(self) -> tuple[Garment, ...]:
        """Return the mesh wherever its deformation may begin: on the target, if it was laid there, and as it drapes.

        On the target its folds are the target's, but lie in each other where the target does not show them; a drape is
        clear of itself, but full skirts hang in other folds, 15 mm off.
        """
        return (self.garment,) if self.laid is None else (self.garment.at(self.laid), self.garment)

    def locks(self, settings: RecoverySettings) -> tuple[str, ...]:
        """Return what the user locks; also the fabric where the cloth was in motion, which tells nothing of it."""
        return settings.locks if self.drape.rotation is None else (*settings.locks, "fabric")
