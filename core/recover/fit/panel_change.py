"""Panels may change: a dart is added where a panel cannot be isometric to the scan, a needless one is closed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...garment import Garment, Pattern, mesh_pattern
from ...garment.editing.darts import Dart, find_darts
from ...garment.editing.partners import mirror_corners
from ...run.errors import Cancelled, GarmentqError
from ...run.hooks import SILENT, Hooks
from ...scan.contours import name_contours
from ..case import Case, GradedDrape
from ..drape import DrapeSettings, drape_graded, hangs_in_sleeves
from ..grade import LEAST_WIDTH, Isometry, PanelChange, SlideSettings, move_pattern, solve_isometry
from .dart_closing import asked_width, close_darts
from .dart_cutting import CutGarment, cut_darts, relax_panels
from .dart_search import is_image, propose_dart, relax_panel, rms_strain
from .isometry import SETTLED, lay_on_target, steps_of, strain_on_target
from .wedge import wanted_strain

if TYPE_CHECKING:
    from ...cloth import SteadyRotation

LEAST_STRAIN = 0.01
"""Root mean square over a panel of the strain that no flat shape of it takes, below which it gets no dart: woven cloth
gives as much."""

PROPOSED_SHARE = 0.4
"""Share of the sum of squared strain that a dart has to take for it to be tried. On panels that were cut without one
the best dart takes 0.36 at most where it is open by `LEAST_ANGLE` (one had 0.45, which a drape with it takes back), on
those that were cut with one 0.43 to 0.7."""

KEPT_SHARE = 1.0 / 3.0
"""The same of one that is kept, after the whole pattern was fitted with it: equal seams, symmetry and proportions leave
some of the strain that the panel alone would be rid of."""

LEAST_ANGLE = np.radians(5.0)
"""Of a dart at its apex [rad]: `LEAST_WIDTH` at a length of 11 cm, between those of front and back skirt darts."""

ROUNDS = 2
"""Times that darts open or close as their panels' strain asks for before they are judged: they change by less than
1 mm in a third."""


@dataclass(frozen=True)
class FittedPanels:
    """Describe a pattern fitted by isometry, whose panels may have changed.

    Attributes:
        garment: The coarse mesh of the fitted pattern, nodes on the target.
        base: The base pattern with the same panels and darts.
        strain: That the cloth of each face is believed to have, shape [face_count, 2, 2].
        graded: A fine mesh of the same panels and darts, nodes at its drape: the graded one's, or with darts added
            that of the pattern with them.
        registered: The nodes of `graded` on the target [m], shape [node_count, 3].
        changes: What changed; empty where nothing did.
    """

    garment: Garment
    base: Pattern
    strain: np.ndarray
    graded: Garment
    registered: np.ndarray
    changes: tuple[PanelChange, ...] = ()


def change_panels(
    garment: Garment, case: Case, drape: GradedDrape, registered: np.ndarray, hooks: Hooks = SILENT
) -> FittedPanels:
    """Close darts that the scan has no use for, and add those that its panels cannot be isometric without.

    Args:
        garment: The pattern as `fit_isometry` left it.
        case: The scan, the wearer and the base pattern; `keep_cut` and locked panels leave panels as they are.
        drape: The graded drape.
        registered: Its nodes on the target [m], shape [node_count, 3].
        hooks: Cancellation.

    Returns:
        The fitted pattern; with nothing changed the one that was given, to the last digit.
    """
    _, strain = lay_on_target(drape.garment, registered)
    found = FittedPanels(garment, case.base, strain, drape.garment, registered)
    if case.settings.keep_cut or case.has_locked_panels:
        return found
    hooks.check()
    try:
        return _add(_close(found, case), case, drape.drape.rotation)
    except Cancelled:
        raise
    except (GarmentqError, np.linalg.LinAlgError):  # changed panels that cannot be meshed or fitted are no better
        return found


def _close(found: FittedPanels, case: Case) -> FittedPanels:
    """Close the darts for which the scan asks for less than `LEAST_WIDTH`, unless one would be proposed again."""
    if not find_darts(found.garment.pattern):
        return found
    relaxed = _relax(found, case, {dart.panel for dart in find_darts(found.garment.pattern)})
    wanted = wanted_strain(relaxed.garment, relaxed.strain)
    widths = {dart: asked_width(relaxed.garment, wanted, dart) for dart in find_darts(relaxed.garment.pattern)}
    needless = [dart for dart, width in widths.items() if width < LEAST_WIDTH]
    needless = [dart for dart in needless if _images(relaxed.garment.pattern, dart) <= set(needless)]
    if not needless:
        return found
    closed = _refit(relaxed, close_darts(relaxed.garment, wanted, relaxed.base, needless), case)
    strains = strains_of(found.garment, found.strain), strains_of(closed.garment, closed.strain)
    changes = []
    for dart in needless:
        before, after = (each[dart.panel] for each in strains)
        if 1.0 - (before / after) ** 2 > PROPOSED_SHARE and after > LEAST_STRAIN:
            return found  # without it one would be proposed
        changes.append(describe_dart(found.garment.pattern, dart, "closed", widths[dart], (before, after)))
    return replace(closed, changes=tuple(changes))


def _add(found: FittedPanels, case: Case, rotation: SteadyRotation | None) -> FittedPanels:
    """Add the darts that take enough strain and come out wide enough; one that does not is taken back.

    What cloth is believed to be strained by is then that of a drape with them. Without them a skirt is compressed at
    its waist, which hides half of what a dart takes in.
    """
    wanted = wanted_strain(found.garment, found.strain)
    before = strains_of(found.garment, found.strain)
    proposals = [
        one
        for index in range(len(found.garment.pattern.panels))
        if not is_image(found.garment, index)
        and (one := propose_dart(found.garment, wanted, index)) is not None
        and one.before > LEAST_STRAIN
        and one.share > PROPOSED_SHARE
        and one.angle > LEAST_ANGLE
    ]
    while proposals:
        cut = cut_darts(found.garment, wanted, found.base, tuple(proposals))
        names = {dart.panel for dart in cut.darts}
        added = _relax(_drape_anew(_refit(found, cut, case), case, rotation), case, names)
        after = strains_of(added.garment, added.strain)
        changes: dict[int, list[PanelChange]] = {}
        for number in range(len(proposals)):
            darts = [dart for dart, owner in zip(cut.darts, cut.owner, strict=True) if owner == number]
            widths = [dart.width(added.garment.pattern) for dart in darts]
            square = [sum(each[name] ** 2 for name in {dart.panel for dart in darts}) for each in (before, after)]
            is_wide = bool(darts) and min(widths) >= LEAST_WIDTH
            if is_wide and square[1] <= (1.0 - KEPT_SHARE) * square[0]:
                changes[number] = [
                    describe_dart(added.garment.pattern, dart, "added", width, (before[dart.panel], after[dart.panel]))
                    for dart, width in zip(darts, widths, strict=True)
                ]
        if len(changes) == len(proposals):
            every = tuple(change for number in sorted(changes) for change in changes[number])
            return replace(added, changes=(*found.changes, *every))
        proposals = [proposals[number] for number in sorted(changes)]
    return found


def _refit(found: FittedPanels, cut: CutGarment, case: Case) -> FittedPanels:
    """Return the panels with other darts, meshed anew and fitted to the target by isometry."""
    garment, strain = fit_cut(cut, found.garment, found.strain, case, _settings_of(case))
    fine = mesh_pattern(cut.pattern, len(found.graded.nodes))
    nodes, registered = (cut.place(found.graded, each, fine) for each in (found.graded.nodes, found.registered))
    return FittedPanels(garment, cut.base, strain, fine.at(nodes), registered, found.changes)


def _drape_anew(found: FittedPanels, case: Case, rotation: SteadyRotation | None) -> FittedPanels:
    """Drape the panels on the wearer, and believe of their cloth on the target what that drape is strained by."""
    start = move_pattern(found.graded, found.garment.pattern)
    settings = DrapeSettings(apart=hangs_in_sleeves(case.target, case.body))
    drape, _ = drape_graded(start, case.wearer, case.fabric, case.target, rotation=rotation, settings=settings)
    return replace(found, strain=strain_on_target(found.garment, drape, found.registered), graded=drape)


def fit_cut(
    cut: CutGarment, before: Garment, strain: np.ndarray, case: Case, settings: SlideSettings
) -> tuple[Garment, np.ndarray]:
    """Mesh a pattern with other darts anew, and fit it to the target by isometry.

    Args:
        cut: The pattern, and where its darts were cut.
        before: The garment without them.
        strain: The strain that the cloth of its faces is believed to have, shape [face_count, 2, 2].
        case: The target and the wearer.
        settings: How.

    Returns:
        The garment, and the strain of its faces.
    """
    mesh = mesh_pattern(cut.pattern, len(before.nodes))
    start = mesh.at(cut.place(before, before.nodes, mesh))
    carried = cut.carry_strain(strain, mesh)
    return _fit(start, carried, cut.base, case, settings), carried


def _relax(found: FittedPanels, case: Case, panels: set[str]) -> FittedPanels:
    """Let the darts of some panels open or close as strain asks for, and fit again, `ROUNDS` times."""
    for _ in range(ROUNDS):
        wanted = wanted_strain(found.garment, found.strain)
        pattern, base = relax_panels(found.garment, wanted, found.base, panels)
        fitted = _fit(move_pattern(found.garment, pattern), found.strain, base, case, _settings_of(case))
        found = replace(found, garment=fitted, base=base)
    return found


def _settings_of(case: Case) -> SlideSettings:
    return SlideSettings(SETTLED, steps_of(case))


def _fit(start: Garment, strain: np.ndarray, base: Pattern, case: Case, settings: SlideSettings) -> Garment:
    """Fit a pattern and its place on the target to each other, from where a garment lies."""
    named = start.at(start.nodes, name_contours(start.nodes, start.faces, case.body)[0])
    problem = Isometry.of(named, case.target, case.body, base, strain, settings.isometry)
    return solve_isometry(problem, named, settings.settled, lambda step: None)


def strains_of(garment: Garment, strain: np.ndarray) -> dict[str, float]:
    """Return the root mean square of the strain that no flat shape takes, by the panel's name.

    Args:
        garment: The flat panels and their nodes on the target.
        strain: That the cloth of each face is believed to have, shape [face_count, 2, 2].
    """
    wanted, strains = wanted_strain(garment, strain), {}
    for index, panel in enumerate(garment.pattern.panels):
        flat = relax_panel(garment, wanted, index)
        strains[panel.name] = rms_strain([flat], float(flat.left @ flat.left))
    return strains


def _images(pattern: Pattern, dart: Dart) -> set[Dart]:
    """Return the mirror images of a dart."""
    darts = find_darts(pattern)
    number = (dart.first + 1) % len(pattern.panel(dart.panel).points)
    apexes = {(one.panel, (one.first + 1) % len(pattern.panel(one.panel).points)): one for one in darts}
    images = mirror_corners(pattern).get((dart.panel, number), [])
    return {apexes[corner] for corner, _ in images if corner in apexes}


def describe_dart(pattern: Pattern, dart: Dart, kind: str, width: float, strain: tuple[float, float]) -> PanelChange:
    """Return a change with its place."""
    panel = pattern.panel(dart.panel)
    edge = panel.edges[(dart.first - 1) % len(panel.edges)]
    first, apex, last = dart.ends(pattern)
    middle = 0.5 * (first + last)
    where = edge.label or edge.contour or str((dart.first - 1) % len(panel.edges))
    points = (float(middle[0]), float(middle[1])), (float(apex[0]), float(apex[1]))
    return PanelChange(kind, panel.name, where, *points, width, *strain)
