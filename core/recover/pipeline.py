"""The stages of a recovery in their order: a reader follows one scan from its file to the measured result."""

from __future__ import annotations

import platform
from dataclasses import asdict, dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from ..body import Body
from ..cloth import Drape, get_fabric
from ..garment import Garment, Panel, Seam, draft_template, find_cut, load_template, mesh_pattern, name_cut, resample
from ..garment.parts import PartsConflict
from ..garment.pieces import measure_pieces
from ..judge import (
    Reference,
    judge,
    measure_contour_shapes,
    measure_fairness,
    measure_fit,
    measure_knowledge,
    measure_plausibility,
    measure_seams,
    measure_upright,
    measure_wear,
)
from ..run.checkpoints import load, save
from ..run.clock import Clock
from ..run.hooks import SILENT, Hooks
from ..run.report import ResultReport
from ..scan.contours import CATEGORIES, Target, find_remarks, mark_hidden_border, name_contours, segment_garment
from ..scan.contours.rounded_rims import straighten_scan
from .case import Case, GradedDrape
from .drape import (
    DrapeSettings,
    WearerGeometry,
    describe_motion,
    drape_as_scanned,
    drape_template,
    hangs_in_sleeves,
    needs_easing,
    outgrown_measures,
    redrape,
)
from .fit import METHODS, DartedGarment, Fit, add_bust_darts, fair_garment, find_held, uncross
from .grade import (
    Candidate,
    Choice,
    PanelChange,
    SlideSettings,
    choose_cut,
    complete_target,
    grade_pattern,
    name_recovered,
    share_by_hems,
    slide_seams,
    tell_cut,
)
from .inputs import read_files, read_template
from .recovery import Recovery, Request
from .settings import SettingsBad
from .wearer import find_wearer

PACKAGES = ("garmentq", "torch", "numpy", "scipy", "numba", "trimesh", "libigl")
"""The packages whose versions decide the digits of a result; the manifest names them."""

GRADINGS = 2
"""Times the pattern is graded: the second starts from the first's mesh on the target and takes out what symmetry and
seams left over; a third moved no panel of the patterns we tried by more than 1 mm."""


def recover(request: Request, hooks: Hooks = SILENT) -> Recovery:
    """Recover pattern, fabric and meshes of one scanned garment.

    Args:
        request: The files and settings.
        hooks: Progress, cancellation and checkpoints.

    Raises:
        BadInput: where a file or a setting cannot be used; the code says why.
        Cancelled: as soon as the hooks say so.
    """
    clock = Clock(hooks)
    case = complete_case(make_case(request, clock), clock)
    remarks = [one.tell() for one in case.undeclared or () if one.is_off_body]
    remarks += find_remarks(case.scan.vertices, case.body)
    drape = drape_to_scan(case, clock)
    if drape.base is not None:
        case = replace(case, base=drape.base)
    # where curves are free the fits start from those that the scan has shown
    shaped = replace(case, base=drape.garment.pattern) if case.has_free_curves else case
    fit = METHODS[request.settings.method].fit(shaped, drape, clock)
    if fit.base is not None and fit.changes:
        case = replace(case, base=fit.base)  # with the darts that were added, without those that were closed
    changes = (*drape.changes, *fit.changes)
    if fit.wearer is not None:
        case = replace(case, wearer=fit.wearer)  # from here on the body is where the cloth rests on it
    if fit.meshes.simulation is not None:
        fit = redrape_pattern(case, drape, fit, clock)
    with clock.stage("measure", "measuring the result"):
        pieces = measure_pieces(fit.garment.pattern)
        metrics = {**measure(case, drape, fit), **pieces.metrics}
        cut = case.template
        if request.template is None:
            cut = name_recovered(fit.garment.pattern, cut, case.body, request.settings.chosen_parts)
    warnings = (
        *remarks,
        *case.scan.repairs,
        *drape.warnings,
        *fit.warnings,
        *(change.tell() for change in changes),
        *(corner.tell() for corner in fit.corners),
        *tell_cut(cut, case.template),
    )
    manifest = describe(case) | {
        "cut": cut,
        "panel_changes": [asdict(change) for change in changes],
        "proved_corners": [corner.record() for corner in fit.corners],
    }
    return Recovery(
        scan=case.scan,
        body=case.body,
        target=case.seen,
        template=case.template,
        pattern=fit.garment.pattern,
        fabric=fit.fabric,
        garment=fit.garment,
        meshes=fit.meshes,
        report=ResultReport.of(clock, metrics, judge(metrics), warnings, manifest),
        estimates=fit.estimates,
        nearest_fabrics=fit.nearest,
        point_std=fit.point_std,
        rotation=drape.drape.rotation,
        pieces=pieces.pieces,
    )


def make_case(request: Request, clock: Clock) -> Case:
    """Read the files, find the wearer, name the garment's contours and choose its base pattern."""
    settings = request.settings
    fabric = get_fabric(settings.fabric)
    with clock.stage("scan", "reading the scan"):
        pieces = read_files(request)
    with clock.stage("body", "finding the wearer's joints") as hooks:
        found = find_wearer(request, pieces, hooks)
    body = found.body
    with clock.stage("segment", "naming the open contours"):
        scan = straighten_scan(pieces.garment)
        target = segment_garment(scan, body)
        category = settings.garment or (None if request.reading is None else request.reading.category)
        if category is not None:
            target = replace(target, category=check_category(category))
    choice = find_template(request, target, body)
    base = replace(choice.pattern, symmetric=settings.free != "symmetry")
    find_held(base, base, settings.locks)  # a lock of nothing is refused now, not after the drape
    wearer = WearerGeometry(body)
    case = Case(request, scan, wearer, target, choice.template, base, fabric)
    return replace(case, candidates=choice.candidates, notes=choice.notes, undeclared=found.undeclared)


def complete_case(case: Case, clock: Clock) -> Case:
    """Return the case with a target that does not end where another garment hides it; others come back as they are."""
    if case.target.hidden is None:
        return case
    with clock.stage("template", "completing what another garment hides") as hooks:
        worn = dress_template(case, hooks)
        completed = complete_target(worn, case.target, case.wearer.exposed, hooks)
    return case if completed is case.target else replace(case, target=completed, scanned=case.target)


def dress_template(case: Case, hooks: Hooks) -> Garment:
    """Dress the wearer in the case's base pattern, to be graded.

    A maker's own is eased where it would hang too low: its seams creep from where they lie, so they have to lie right;
    those of tops and of the library slide.
    """
    is_eased = not case.has_free_curves and needs_easing(case.base, case.target.category)
    settings = DrapeSettings().eased() if is_eased else DrapeSettings()
    return drape_template(case.base, case.wearer, case.target, settings=settings, hooks=hooks)


@dataclass(frozen=True)
class _KeptDrape:
    """The checkpoint `drape`: the same pattern and vertex count give the same mesh, so that is not in it.

    Attributes:
        panels: Of the graded pattern.
        drawn: Of the base pattern with the same darts.
        seams: Of both.
        changes: Darts that the scan has shown.
        nodes: Of the garment on the wearer [m], shape [node_count, 3].
        drape: The equilibrium.
        warnings: What the user should know.
        laid: The nodes where the sliding left them on the target [m], shape [node_count, 3], or None.
    """

    panels: tuple[Panel, ...]
    drawn: tuple[Panel, ...]
    seams: tuple[Seam, ...]
    changes: tuple[PanelChange, ...]
    nodes: np.ndarray
    drape: Drape
    warnings: tuple[str, ...]
    laid: np.ndarray | None


def drape_to_scan(case: Case, clock: Clock) -> GradedDrape:
    """Dress the wearer in the base pattern, grade it to the target and drape what was graded."""
    base, count = case.base, case.settings.vertex_count
    kept = load(clock.hooks, "drape", _KeptDrape, base.points, count)
    if kept is not None:
        garment = mesh_pattern(replace(base, panels=kept.panels, seams=kept.seams), count)
        if len(garment.nodes) == len(kept.nodes):  # another release may mesh the same points otherwise
            contours, _ = name_contours(kept.nodes, garment.faces, case.body)
            worn = garment.at(kept.nodes, contours)
            darted = replace(base, panels=kept.drawn, seams=kept.seams)
            return GradedDrape(worn, kept.drape, kept.warnings, kept.laid, darted, kept.changes)
    with clock.stage("template", "dressing the body in the template") as hooks:
        worn = dress_template(case, hooks)
    with clock.stage("grade", "grading the pattern to the scan") as hooks:
        slid, notes = grade(case, worn, hooks)
    with clock.stage("drape", "draping the graded pattern") as hooks:
        settings = DrapeSettings(apart=hangs_in_sleeves(case.target, case.body))
        garment, drape = drape_as_scanned(
            slid.garment, case.wearer, case.fabric, case.target, vertex_count=count, settings=settings, hooks=hooks
        )
        if settings.apart:
            garment, drape = uncross(case, garment, drape, hooks)
        is_laid = case.has_free_curves and not settings.apart
        laid = resample(slid.garment, slid.garment.nodes, garment) if is_laid else None
    motion = () if drape.rotation is None else (describe_motion(drape.rotation),)
    warnings = (
        *case.notes,
        *_note_hidden(case),
        *notes,
        *motion,
        *(() if drape.at_rest else (f"the graded drape is {drape.advice}",)),
    )
    panels = garment.pattern.panels, slid.base.panels
    state = _KeptDrape(*panels, slid.base.seams, slid.changes, garment.nodes, drape, warnings, laid)
    save(clock.hooks, "drape", state, base.points, count)
    return GradedDrape(garment, drape, warnings, laid, slid.base, slid.changes)


def _note_hidden(case: Case) -> tuple[str, ...]:
    """Return which ends of the garment are the base pattern's, one sentence each."""
    shown = {contour.name for contour in case.seen.contours if not contour.hidden}
    guessed = (
        []
        if case.scanned is None
        else [end.name for end in case.target.contours if end.name not in shown and not end.hidden]
    )
    return tuple(
        f"The contour '{name}' is hidden; beyond what is seen the garment is its base pattern's." for name in guessed
    )


def grade(case: Case, worn: Garment, hooks: Hooks) -> tuple[DartedGarment, tuple[str, ...]]:
    """Grade a worn base pattern to the target, and slide its seams, and shape its curves, to where the cloth has them.

    Returns:
        The graded garment on the target, its front with darts where only they make the cloth as pointed as it is, and
        what the user should know.
    """
    grading = grade_pattern(worn, case.target, case.body, hooks=hooks)
    for _ in range(GRADINGS - 1):
        grading = grade_pattern(grading.garment, case.target, case.body, hooks=hooks)
    settings = SlideSettings().by_newton(case.has_free_curves) if case.has_far_seams else SlideSettings()
    slid = slide_seams(grading.garment, case.target, case.body, case.base, settings=settings, hooks=hooks)
    found = DartedGarment(slid, case.base)
    if case.has_free_curves:
        if not case.settings.keep_cut:
            found = add_bust_darts(slid, grading.garment, case, settings)
        fair = fair_garment(found.garment, found.base, find_held(found.garment.pattern, found.base, ()))
        found = replace(found, garment=fair)
    return found, tuple(grading.warnings)


def redrape_pattern(case: Case, drape: GradedDrape, fit: Fit, clock: Clock) -> Fit:
    """Return the fit with its pattern draped anew from its rest placement, in the graded drape's rotation if any."""
    with clock.stage("redrape", "dressing the body in the recovered pattern") as hooks:
        rotation = drape.drape.rotation
        nodes, again = redrape(fit.garment, case.wearer, fit.fabric, case.target, rotation=rotation, hooks=hooks)
    warnings = () if again.at_rest else (f"the re-draped mesh is {again.advice}",)
    meshes = replace(fit.meshes, redraped=nodes)
    return replace(fit, meshes=meshes, redrape=again, warnings=(*fit.warnings, *warnings))


def find_template(request: Request, target: Target, body: Body) -> Choice:
    """Return the base pattern: the given file, the named template with the chosen parts, or what the scan shows.

    One that is not given is shared out between front and back as the scan's hems say (`share_by_hems`).

    Raises:
        PartsConflict: where parts are chosen for a pattern file, or they cannot be sewn to each other.
    """
    given, settings = read_template(request), request.settings
    if request.template is not None and given is not None:
        if settings.parts is not None:
            raise PartsConflict(f"the parts of a pattern file are drawn in it; leave out '{settings.parts}'.")
        return Choice(request.template.stem, given)
    if settings.template is None:
        choice = choose_cut(target, body, settings.chosen_parts)
    else:
        stem = settings.template.partition("+")[0]
        name = name_cut(stem, find_cut(settings.template).choose(settings.chosen_parts))
        measures = outgrown_measures(body)
        choice = Choice(name, load_template(name) if measures is None else draft_template(name, measures))
    pattern, shares = share_by_hems(choice.pattern, target, body)
    return replace(choice, pattern=pattern, notes=(*choice.notes, *(share.tell() for share in shares)))


def check_category(name: str) -> str:
    """Return the category back if there is one of that name.

    Raises:
        SettingsBad: where there is none.
    """
    if name not in CATEGORIES:
        raise SettingsBad(f"garment '{name}' is not one of {', '.join(CATEGORIES)}.")
    return name


def measure(case: Case, drape: GradedDrape, fit: Fit) -> dict[str, float | None]:
    """Measure all meshes against the scan, the truth that the user gave, and what the fit knows."""
    scan = case.scan
    contours = case.seen.contours_of_scan()
    hidden = mark_hidden_border(scan.faces, scan.hidden, contours)
    truth = Reference(scan.vertices, scan.faces, contours, case.wearer.exposed, case.settings.seed, hidden=hidden)
    metrics = measure_knowledge(fit.estimates, fit.point_std)
    for name, equilibrium in (("drape", drape.drape), ("sim", fit.simulated), ("redrape", fit.redrape)):
        if equilibrium is not None:
            metrics |= equilibrium.measure(name)
    metrics |= measure_fit(fit.garment, fit.meshes, truth)
    metrics |= measure_seams(fit.garment.pattern) | measure_fairness(
        fit.garment.pattern, case.base, {corner.join: corner.angle for corner in fit.corners}
    )
    metrics |= measure_plausibility(fit.garment.pattern)
    metrics |= measure_contour_shapes(fit.garment, fit.meshes.drape_on_scan, case.seen, case.body)
    metrics |= measure_wear(case.target, case.body, fit.meshes.detail, fit.garment.faces, case.settings.seed)
    metrics |= measure_upright(case.seen)
    for name, candidate in zip(("cut.misfit", "cut.next_misfit", "cut.third_misfit"), case.candidates, strict=False):
        metrics[name] = candidate.misfit
    metrics["drape.spin_rad_s"] = 0.0 if drape.drape.rotation is None else drape.drape.rotation.rate
    metrics["body.fit_rms_mm"] = 1e3 * case.body.fit_rms
    if case.undeclared is not None:
        metrics["body.undeclared_mm"] = 1e3 * max((one.offset for one in case.undeclared), default=0.0)
    return metrics


def describe(case: Case) -> dict[str, Any]:
    """Return what reproduces the result: versions, hashes, settings and what was understood of the input."""
    scan, body = case.scan, case.body
    return {
        "versions": {name: _version(name) for name in PACKAGES} | {"python": platform.python_version()},
        "scan": {"name": scan.name, "sha256": scan.sha256, "units": scan.units, "up": scan.up_axis},
        "body": {"source": body.source, "fit_rms_m": float(np.round(body.fit_rms, 6))},
        "template": case.template,
        "candidates": [_describe_candidate(one) for one in case.candidates],
        "category": case.target.category,
        "fitted_faces": len(case.target.faces),
        "settings": case.settings.as_dict(),
    }


def _describe_candidate(candidate: Candidate) -> dict[str, Any]:
    """Return a cut's name and what its misfit is made of."""
    parts = {name: getattr(candidate, name) for name in ("misfit", "girths", "neckline")}
    return {"template": candidate.template} | {
        name: float(np.round(value, 4)) for name, value in parts.items() if value is not None
    }


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
