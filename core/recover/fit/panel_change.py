"""Change panels: add a dart where a panel cannot be isometric to the scan, and close needless ones."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...garment.editing.darts import Dart, find_darts
from ...garment.editing.partners import mirror_corners
from ...garment.garment import Garment
from ...garment.meshes import Meshes
from ...garment.pattern import Pattern
from ...garment.sewing import mesh_pattern
from ...run.errors import Cancelled, GarmentqError
from ...run.finding import Finding, FindingKind
from ...run.hooks import SILENT_HOOKS, Hooks
from ..case import Case
from ..drape.stage import DrapeSettings, drape_graded, has_hanging_sleeves
from ..drape.worn_contours import name_worn_contours
from ..grade.grading import move_pattern
from ..grade.isometry import Isometry
from ..grade.sliding import SlideSettings, solve_isometry
from ..state import RecoveryState, made
from .dart_closing import close_darts, required_dart_width
from .dart_cutting import CutGarment, cut_darts, relax_panels
from .dart_search import is_mirror_image, propose_dart, relax_panel, rms_strain
from .isometry import CONTROL_POINT_TOLERANCE, choose_isometry_settings, mesh_on_target, strain_on_target
from .wedge import wanted_strain

MIN_DART_WIDTH = 0.01
"""Smallest width of the mouth of a dart [m]: a narrower one is within 5 mm of its fold and eased."""

MIN_DART_ANGLE = np.radians(5.0)
"""Smallest angle of a dart at its apex [rad]: `MIN_DART_WIDTH` at 11 cm, between skirt darts' lengths."""


@dataclass(frozen=True)
class PanelChangeSettings:
    """Describe when darts are added and closed.

    Attributes:
        strain: RMS over a panel of the strain that no flat shape takes [1] below which it gets no dart: woven cloth's.
        proposed_share: Share of the sum of squared strain that a dart has to take to be tried. On panels cut without
            one the best of `MIN_DART_ANGLE` takes at most 0.36 (one 0.45, which a drape rejects), with one 0.43 to 0.7.
        kept_share: Share of the same sum for a dart that is kept, after the whole pattern was fitted with it: equal
            seams, symmetry and proportions leave some strain that the panel alone would not have.
        iterations: Number of steps in which darts open or close before they are judged: a third moves less than 1 mm.
    """

    strain: float = 0.01
    proposed_share: float = 0.4
    kept_share: float = 1.0 / 3.0
    iterations: int = 2


StrainedState = tuple[RecoveryState, np.ndarray]
"""A state with a coarse mesh of a pattern fitted by isometry, nodes on the target, and the `meshes` of `graded`, a fine
mesh of the same panels; and the estimated strain of the coarse mesh's faces, shape [face_count, 2, 2]."""


def change_panels(
    case: Case, state: RecoveryState, hooks: Hooks = SILENT_HOOKS, settings: PanelChangeSettings = PanelChangeSettings()
) -> RecoveryState:
    """Close darts that the scan does not need, and add those without which panels cannot be isometric to it.

    Args:
        case: `keep_cut` and locked panels leave panels as they are.
        state: The garment from `fit_isometry`, its base pattern, the graded drape, and its nodes on the target.
        hooks: Cancellation.
        settings: When darts are added and closed.

    Returns:
        The fitted pattern with the base pattern and the graded drape of the same panels (a new drape where darts were
        added); the given state where nothing changed.
    """
    if case.settings.keep_cut or case.has_locked_panels:
        return state
    hooks.check()
    _, strain = mesh_on_target(made(state.graded), made(state.meshes).detail)
    try:
        return _add_darts(case, _close_darts(case, (state, strain), settings), settings)
    except Cancelled:
        raise
    except (GarmentqError, np.linalg.LinAlgError):  # changed panels that cannot be meshed or fitted are no better
        return state


def _close_darts(case: Case, start: StrainedState, settings: PanelChangeSettings) -> StrainedState:
    """Close the darts that need less than `MIN_DART_WIDTH`, unless one would be proposed again."""
    state, strain = start
    garment = made(state.garment)
    if not find_darts(garment.pattern):
        return start
    relaxed, its_strain = _relax_darts(case, start, {dart.panel for dart in find_darts(garment.pattern)}, settings)
    loose = made(relaxed.garment)
    target = wanted_strain(loose, its_strain)
    widths = {dart: required_dart_width(loose, target, dart) for dart in find_darts(loose.pattern)}
    needless = [dart for dart, width in widths.items() if width < MIN_DART_WIDTH]
    needless = [dart for dart in needless if _mirror_images(loose.pattern, dart) <= set(needless)]
    if not needless:
        return start
    closed, after_strain = _refit(case, (relaxed, its_strain), close_darts(loose, target, relaxed.base, needless))
    strains = panel_strains(garment, strain), panel_strains(made(closed.garment), after_strain)
    changes = []
    for dart in needless:
        before, after = (each[dart.panel] for each in strains)
        if 1.0 - (before / after) ** 2 > settings.proposed_share and after > settings.strain:
            return start  # without it one would be proposed
        changes.append(describe_dart(garment.pattern, dart, "closed", widths[dart], (before, after)))
    return closed.with_findings(*changes), after_strain


def _add_darts(case: Case, start: StrainedState, settings: PanelChangeSettings) -> RecoveryState:
    """Add the darts that take enough strain and are wide enough; others are removed again.

    The strain is then that of a drape with them: without them compression at a skirt's waist hides half the intake.
    """
    state, strain = start
    garment = made(state.garment)
    target, before = wanted_strain(garment, strain), panel_strains(garment, strain)
    proposals = [
        one
        for index in range(len(garment.pattern.panels))
        if not is_mirror_image(garment, index)
        and (one := propose_dart(garment, target, index)) is not None
        and one.before > settings.strain
        and one.share > settings.proposed_share
        and one.angle > MIN_DART_ANGLE
    ]
    while proposals:
        cut = cut_darts(garment, target, state.base, tuple(proposals))
        names = {dart.panel for dart in cut.darts}
        added, its_strain = _relax_darts(case, _drape_with_darts(case, _refit(case, start, cut)), names, settings)
        pattern, after = made(added.garment).pattern, panel_strains(made(added.garment), its_strain)
        changes: dict[int, list[Finding]] = {}
        for number in range(len(proposals)):
            darts = [dart for dart, owner in zip(cut.darts, cut.owner, strict=True) if owner == number]
            widths = [dart.width(pattern) for dart in darts]
            square = [sum(each[name] ** 2 for name in {dart.panel for dart in darts}) for each in (before, after)]
            is_wide = bool(darts) and min(widths) >= MIN_DART_WIDTH
            if is_wide and square[1] <= (1.0 - settings.kept_share) * square[0]:
                changes[number] = [
                    describe_dart(pattern, dart, "added", width, (before[dart.panel], after[dart.panel]))
                    for dart, width in zip(darts, widths, strict=True)
                ]
        if len(changes) == len(proposals):
            return added.with_findings(*(change for number in sorted(changes) for change in changes[number]))
        proposals = [proposals[number] for number in sorted(changes)]
    return state


def _refit(case: Case, before: StrainedState, cut: CutGarment) -> StrainedState:
    """Return the panels with other darts, meshed again and fitted to the target by isometry."""
    state, strain = before
    graded, nodes = made(state.graded), made(state.meshes)
    garment, carried = refit_with_darts(cut, made(state.garment), strain, state, _settings_of(case))
    fine = mesh_pattern(cut.pattern, len(graded.nodes))
    placed, registered = (cut.place(graded, each, fine) for each in (graded.nodes, nodes.detail))
    meshes = Meshes(placed, registered)
    return replace(state, garment=garment, base=cut.base, graded=fine.at(placed), meshes=meshes), carried


def _drape_with_darts(case: Case, before: StrainedState) -> StrainedState:
    """Drape the panels on the wearer, and estimate their cloth's strain on the target from that drape."""
    state, _ = before
    garment, registered = made(state.garment), made(state.meshes).detail
    start, rotation = move_pattern(made(state.graded), garment.pattern), made(state.drape).rotation
    settings = DrapeSettings(self_contact=has_hanging_sleeves(state.target, case.body))
    drape, _ = drape_graded(start, state.wearer, state.fabric, state.target, rotation=rotation, settings=settings)
    state = replace(state, graded=drape, meshes=Meshes(drape.nodes, registered))
    return state, strain_on_target(garment, drape, registered)


def refit_with_darts(
    cut: CutGarment, before: Garment, strain: np.ndarray, state: RecoveryState, settings: SlideSettings
) -> tuple[Garment, np.ndarray]:
    """Mesh a pattern with other darts again, and fit it to the target by isometry.

    Args:
        cut: The pattern, and where its darts were cut.
        before: The garment without them.
        strain: The estimated strain of the cloth of its faces, shape [face_count, 2, 2].
        state: The target and the wearer.
        settings: Steps and their end.

    Returns:
        The garment, and the strain of its faces.
    """
    mesh = mesh_pattern(cut.pattern, len(before.nodes))
    start = mesh.at(cut.place(before, before.nodes, mesh))
    carried = cut.carry_strain(strain, mesh)
    return _fit(start, carried, cut.base, state, settings), carried


def _relax_darts(case: Case, before: StrainedState, panels: set[str], settings: PanelChangeSettings) -> StrainedState:
    """Open or close the darts of some panels by their strain, and fit again, `iterations` times."""
    state, strain = before
    for _ in range(settings.iterations):
        garment = made(state.garment)
        pattern, base = relax_panels(garment, wanted_strain(garment, strain), state.base, panels)
        fitted = _fit(move_pattern(garment, pattern), strain, base, state, _settings_of(case))
        state = replace(state, garment=fitted, base=base)
    return state, strain


def _settings_of(case: Case) -> SlideSettings:
    return SlideSettings(CONTROL_POINT_TOLERANCE, choose_isometry_settings(case))


def _fit(start: Garment, strain: np.ndarray, base: Pattern, state: RecoveryState, settings: SlideSettings) -> Garment:
    """Fit a pattern and its nodes on the target to each other, from a garment's nodes."""
    named = start.at(start.nodes, name_worn_contours(start, start.nodes, state.body))
    problem = Isometry.of(named, state.target, state.body, base, strain, settings.isometry)
    return solve_isometry(problem, named, settings.settled, lambda step: None)


def panel_strains(garment: Garment, strain: np.ndarray) -> dict[str, float]:
    """Return the root mean square of the strain that no flat shape takes, by the panel's name.

    Args:
        garment: The flat panels and their nodes on the target.
        strain: Estimated strain of the cloth of each face, shape [face_count, 2, 2].
    """
    target, strains = wanted_strain(garment, strain), {}
    for index, panel in enumerate(garment.pattern.panels):
        flat = relax_panel(garment, target, index)
        strains[panel.name] = rms_strain([flat], float(flat.left @ flat.left))
    return strains


def _mirror_images(pattern: Pattern, dart: Dart) -> set[Dart]:
    """Return the mirror images of a dart."""
    darts = find_darts(pattern)
    number = (dart.first + 1) % len(pattern.panel(dart.panel).points)
    apexes = {(one.panel, (one.first + 1) % len(pattern.panel(one.panel).points)): one for one in darts}
    images = mirror_corners(pattern).get((dart.panel, number), [])
    return {apexes[corner] for corner, _ in images if corner in apexes}


def describe_dart(pattern: Pattern, dart: Dart, kind: str, width: float, strain: tuple[float, float]) -> Finding:
    """Return the finding that a dart was added or closed, with its place and evidence.

    Args:
        pattern: The pattern that has the dart.
        dart: The dart.
        kind: `added` or `closed`.
        width: Of its mouth [m]; of a closed one the width that the scan needs.
        strain: Root mean square over the panel of the strain that no flat shape takes, before and after.
    """
    panel = pattern.panel(dart.panel)
    edge = panel.edges[(dart.first - 1) % len(panel.edges)]
    first, apex, last = dart.ends(pattern)
    mouth, end = 0.5 * (first + last), edge.label or edge.contour or str((dart.first - 1) % len(panel.edges))
    evidence = {
        "kind": kind, "panel": panel.name, "edge": end, "mouth": [float(x) for x in mouth],
        "apex": [float(x) for x in apex], "width": float(width), "before": float(strain[0]), "after": float(strain[1]),
    }  # fmt: skip
    fall, where = f"{100 * strain[0]:.1f} to {100 * strain[1]:.1f} %", f"panel '{panel.name}' at '{end}'"
    if kind == "added":
        message = (
            f"A dart of {1e3 * width:.0f} mm, {1e3 * float(np.linalg.norm(apex - mouth)):.0f} mm long, was added to "
            f"{where}: the strain that no flat panel takes falls from {fall} there; --keep-cut leaves it out."
        )
    else:
        message = (
            f"A dart of {where} was closed: the scan needs {1e3 * width:.0f} mm, less than "
            f"{1e3 * MIN_DART_WIDTH:.0f}, and without it strain goes from {fall}; --keep-cut leaves it."
        )
    return Finding(FindingKind.PANEL_CHANGE, message, width, evidence)
