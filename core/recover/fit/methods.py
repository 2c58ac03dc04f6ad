"""The methods of recovery behind one door: `METHODS[name].fit(case, drape, clock)`.

A method starts from the graded pattern's drape and ends at a `Fit`. To add one, write a frozen class with `fit`, and
enter it in `METHODS` and its name in `settings.METHODS`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from ...garment import Garment
from ...garment.meshes import Meshes
from ...run.clock import Clock
from ...run.errors import Cancelled, GarmentqError
from ..case import Case, GradedDrape
from ..deform import Deformation, DeformSettings, deform
from ..drape.motion import miss
from .descent import InverseSettings
from .fairness import fair_garment
from .hybrid import fit_pattern
from .inverse import fit_inverse
from .locks import find_held
from .material import nearest_fabrics
from .result import Fit
from .rim_corners import ProvedCorner, prove_corners
from .settings import ShapeSettings


class Method(Protocol):
    """A way from the graded drape to a recovered garment."""

    def fit(self, case: Case, drape: GradedDrape, clock: Clock) -> Fit:
        """Recover the garment; the stages `deform` and, where there is a simulation mesh, `fit` are timed by the clock.

        Raises:
            Cancelled: as soon as the clock's hooks say so.
        """


@dataclass(frozen=True)
class Graded:
    """Keep the graded pattern, and deform its cloth onto the scan.

    **Deviation** from thesis chapter 4, which begins with the drape: but for the preset `thesis` it also begins where
    the sliding of the seams left the cloth (`GradedDrape.starts`), and the nearer result is taken.
    """

    def fit(self, case: Case, drape: GradedDrape, clock: Clock) -> Fit:
        """Return the graded pattern with its detail mesh, without a simulation mesh."""
        starts = drape.starts if case.settings.preset != "thesis" else (drape.garment,)
        detail = _deform(case, starts, clock)
        meshes = Meshes(drape.garment.nodes, detail.nodes)
        fair, corners = _fair(case, drape, drape.garment, detail.nodes)
        return Fit(fair, case.fabric, meshes, warnings=detail.warnings, corners=corners)


@dataclass(frozen=True)
class Hybrid:
    """Register the graded drape, then refit the pattern to it by isometry and through the simulator.

    Attributes:
        settings: How to fit through the simulator.
    """

    settings: ShapeSettings = field(default_factory=ShapeSettings)

    def fit(self, case: Case, drape: GradedDrape, clock: Clock) -> Fit:
        """Return the fitted pattern; where the fit fails, the graded one with a warning that says why."""
        graded = Graded().fit(case, drape, clock)
        with clock.stage("fit", "fitting the pattern through the simulator") as hooks:
            try:
                found = fit_pattern(case, drape, graded.meshes.detail, self.settings, hooks)
            except Cancelled:
                raise
            except (GarmentqError, np.linalg.LinAlgError) as error:
                failed = f"the pattern is the graded one, for it could not be fitted through the simulator: {error}"
                return replace(graded, warnings=(*graded.warnings, failed))
        return replace(found, warnings=(*graded.warnings, *found.warnings))


@dataclass(frozen=True)
class Inverse:
    """Descend from the graded pattern through the simulator (the thesis' loop), and deform what it ends at.

    Attributes:
        settings: Weights and steps of the descent.
    """

    settings: InverseSettings = field(default_factory=InverseSettings)

    def fit(self, case: Case, drape: GradedDrape, clock: Clock) -> Fit:
        """Return the pattern and fabric that were descended to."""
        with clock.stage("fit", "descending through the simulator") as hooks:
            found = fit_inverse(case, drape, self.settings, hooks)
        detail = _deform(case, (found.garment,), clock)
        fair, corners = _fair(case, drape, found.garment, detail.nodes)
        return Fit(
            garment=fair,
            fabric=found.fabric,
            meshes=Meshes(found.graded, detail.nodes, found.garment.nodes),
            estimates=found.estimates,
            nearest=nearest_fabrics(found.fabric),
            simulated=found.simulated,
            warnings=(*found.warnings, *detail.warnings),
            corners=corners,
        )


METHODS: Mapping[str, Method] = {"deform": Graded(), "inverse": Inverse(), "hybrid": Hybrid()}
"""Every method by the name that `RecoverySettings.method` has."""


def _fair(
    case: Case, drape: GradedDrape, garment: Garment, nodes: np.ndarray
) -> tuple[Garment, tuple[ProvedCorner, ...]]:
    """Return a garment with fair curves at its nodes on the scan, and the corners it keeps; locked points stay."""
    corners = prove_corners(garment, nodes, case.seen, case.base)
    held = find_held(garment.pattern, case.base, drape.locks(case.settings))
    return fair_garment(garment, case.base, held, corners).at(nodes), corners


def _deform(case: Case, starts: Sequence[Garment], clock: Clock) -> Deformation:
    """Deform a mesh onto the scan from each of some places, with the preset that was asked for; return the nearest."""
    settings = DeformSettings.of_preset(case.settings.preset)
    found: list[Deformation] = []
    with clock.stage("deform", "deforming the garment onto the scan") as hooks:
        for start in starts:
            told = hooks if not found else hooks.quiet()
            found.append(deform(start, case.target, case.wearer.exposed, settings=settings, hooks=told))
        if len(found) == 1:
            return found[0]
        return min(found, key=lambda one: miss(starts[0].at(one.nodes), case.target))
