"""The stages of a recovery in their order: a reader follows one scan from its file to the measured result."""

from __future__ import annotations

import platform
import resource
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from .body import Body, BodyMissing, builtin_body, is_builtin, is_smpl, load_smpl, register_body
from .checkpoints import keep_body, keep_drape, kept_body, kept_drape
from .deform import Deformation, DeformSettings, deform
from .drape import WearerGeometry, describe_motion, drape_as_scanned, drape_template, redrape
from .errors import Cancelled, GarmentqError
from .fit import InverseFit, PatternFit, find_held, fit_inverse, fit_pattern
from .grade import choose_template, grade_pattern, slide_seams
from .hooks import SILENT, Hooks
from .measure import judge, measure_fit, measure_knowledge, measure_seams
from .pattern import Garment, Pattern, list_templates, load_pattern, load_template
from .recovery import Recovery, Request
from .scan import Pieces, Scan, load_pieces
from .segment import CATEGORIES, Target, segment_garment
from .settings import RecoverySettings, SettingsBad
from .simulate import Drape, Fabric, get_fabric

PACKAGES = ("garmentq", "torch", "numpy", "scipy", "numba", "trimesh", "libigl")
"""The packages whose versions decide the digits of a result; the manifest names them."""

GRADINGS = 2
"""Times the pattern is graded: the second starts from the first's mesh on the target and takes out what symmetry and
seams left over; a third moved no panel of the patterns we tried by more than 1 mm."""


class Clock:
    """Measure CPU seconds by stage and tell the hooks which stage runs."""

    def __init__(self, hooks: Hooks) -> None:
        self.hooks = hooks
        self.seconds: dict[str, float] = {}
        self.start = time.process_time()

    @contextmanager
    def stage(self, name: str, message: str) -> Iterator[Hooks]:
        """Time one stage; the hooks it hands out report fractions under the stage's name."""
        self.hooks.progress(name, 0.0, message)
        before = time.process_time()
        yield replace(self.hooks, on_progress=lambda _, fraction, text: self.hooks.on_progress(name, fraction, text))
        self.seconds[name] = time.process_time() - before
        self.hooks.progress(name, 1.0, message)

    @property
    def total(self) -> float:
        """Give the CPU seconds since the start."""
        return time.process_time() - self.start


def recover(request: Request, hooks: Hooks = SILENT) -> Recovery:
    """Recover pattern, fabric and meshes of one scanned garment.

    Args:
        request: The files and settings.
        hooks: Progress, cancellation and checkpoints.

    Raises:
        BadInput: where a file or a setting cannot be used; the code says why.
        Cancelled: as soon as the hooks say so.
    """
    settings = request.settings
    fabric = get_fabric(settings.fabric)
    clock = Clock(hooks)
    with clock.stage("scan", "reading the scan"):
        pieces = read_files(request)
        scan = pieces.garment
    with clock.stage("body", "finding the wearer's joints") as inner:
        body = find_body(request, pieces, inner)
    with clock.stage("segment", "naming the open contours"):
        target = segment_garment(scan, body)
        if settings.garment is not None:
            target = replace(target, category=check_category(settings.garment))
    template, base = find_template(request, target)
    base = replace(base, symmetric=settings.free != "symmetry")
    find_held(base, base, settings.locks)  # a lock of nothing is refused now, not after the drape
    wearer = WearerGeometry(body)
    garment, drape, notes = drape_to_scan(base, wearer, target, settings, clock)
    warnings = [*scan.repairs, *notes]
    simulation: np.ndarray | None = None
    fitted: PatternFit | InverseFit | None = None
    graded = garment.nodes
    # cloth in motion tells nothing of its fabric
    locks = settings.locks if drape.rotation is None else (*settings.locks, "fabric")
    if settings.method == "inverse":
        with clock.stage("fit", "descending through the simulator") as inner:
            fitted = fit_inverse(
                garment, target, base, fabric, wearer,
                vertex_count=settings.vertex_count, locks=locks, rotation=drape.rotation, hooks=inner,
            )  # fmt: skip
        fabric, garment, graded, simulation = fitted.fabric, fitted.garment, fitted.graded, fitted.simulation
        warnings += fitted.warnings
    with clock.stage("deform", "deforming the drape onto the scan") as inner:
        preset = DeformSettings.thesis() if settings.preset == "thesis" else DeformSettings()
        detail = deform(garment, target, wearer.exposed, settings=preset, hooks=inner)
        warnings += detail.warnings
    garment = garment.at(graded)
    if settings.method == "hybrid":
        with clock.stage("fit", "fitting the pattern through the simulator") as inner:
            found = refit(
                garment, detail.nodes, target, base, fabric, wearer,
                vertex_count=settings.vertex_count, deforming=preset, locks=locks, rotation=drape.rotation, hooks=inner,
            )  # fmt: skip
        if isinstance(found, PatternFit):
            fitted, fabric, detail = found, found.fabric, found.detail
            garment, simulation = found.garment.at(found.graded), found.simulation
            warnings += found.warnings
        else:
            warnings.append(found)
    redraped = None
    known: dict[str, float | None] = {}
    if fitted is not None:
        known = measure_knowledge(fitted.estimates, getattr(fitted, "point_std", None))
        with clock.stage("redrape", "dressing the body in the recovered pattern") as inner:
            redraped, again = redrape(garment, wearer, fabric, target, rotation=drape.rotation, hooks=inner)
        if not again.converged:
            warnings.append(f"the re-draped mesh is {again.outcome.advice}")
        known |= {"redrape.residual": again.residual, "redrape.iterations": float(again.iterations)}
    with clock.stage("measure", "measuring the result"):
        metrics = known | measure(scan, target, garment, detail, simulation, drape, wearer, settings, redraped)
    return Recovery(
        scan=scan,
        body=body,
        target=target,
        template=template,
        pattern=garment.pattern,
        fabric=fabric,
        garment=garment.at(detail.nodes),
        graded=garment.nodes,
        detail=detail.nodes,
        simulation=simulation,
        metrics=metrics,
        gates=judge(metrics),
        warnings=tuple(dict.fromkeys(warnings)),
        stage_seconds=clock.seconds,
        cpu_seconds=clock.total,
        peak_mb=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        manifest=describe(request, scan, body, template, target),
        estimates=() if fitted is None else fitted.estimates,
        nearest_fabrics=() if fitted is None else fitted.nearest,
        point_std=fitted.point_std if isinstance(fitted, PatternFit) else None,
        redraped=redraped,
    )


def refit(
    garment: Garment,
    registered: np.ndarray,
    target: Target,
    base: Pattern,
    fabric: Fabric,
    wearer: WearerGeometry,
    **options: Any,
) -> PatternFit | str:
    """Recover the pattern through the simulator; where that fails, say why: the graded pattern then stands."""
    try:
        return fit_pattern(garment, registered, target, base, fabric, wearer, **options)
    except Cancelled:
        raise
    except (GarmentqError, np.linalg.LinAlgError) as error:
        return f"the pattern is the graded one, for it could not be fitted through the simulator: {error}"


def drape_to_scan(
    base: Pattern, wearer: WearerGeometry, target: Target, settings: RecoverySettings, clock: Clock
) -> tuple[Garment, Drape, list[str]]:
    """Dress the wearer in a base pattern, grade it to the target and drape what was graded.

    Returns:
        The graded garment at rest, its drape, and what the user should know.
    """
    body = wearer.body
    kept = kept_drape(clock.hooks, base, settings.vertex_count, body)
    if kept is not None:
        return kept
    with clock.stage("template", "dressing the body in the template") as inner:
        worn = drape_template(base, wearer, target, hooks=inner)
    with clock.stage("grade", "grading the pattern to the scan") as inner:
        grading = grade_pattern(worn, target, body, hooks=inner)
        for _ in range(GRADINGS - 1):
            grading = grade_pattern(grading.garment, target, body, hooks=inner)
        graded = slide_seams(grading.garment, target, body, base, hooks=inner)
    warnings = list(grading.warnings)
    with clock.stage("drape", "draping the graded pattern") as inner:
        fabric = get_fabric(settings.fabric)
        garment, drape = drape_as_scanned(
            graded, wearer, fabric, target, vertex_count=settings.vertex_count, hooks=inner
        )
    if drape.rotation is not None:
        warnings.append(describe_motion(drape.rotation))
    if not drape.converged:
        warnings.append(drape.outcome.advice)
    keep_drape(clock.hooks, garment, drape, warnings)
    return garment, drape, warnings


def read_files(request: Request) -> Pieces:
    """Read the garment and its wearer, or cut the garment out of a dressed person's scan.

    Raises:
        BodyMissing: where no body is given, and none is in the scan.
        BadInput: where a file cannot be used.
    """
    selection = request.selection
    if request.body is None and selection is None:
        raise BodyMissing()
    given = None if request.body is None or is_builtin(request.body) else Path(request.body)
    settings = request.settings
    return load_pieces(request.scan, given, units=settings.units, up=settings.up, selection=selection)


def find_body(request: Request, pieces: Pieces, hooks: Hooks) -> Body:
    """Register the given mesh or the dressed person, read a body of SMPL's format, or make the built-in body."""
    wearer = pieces.wearer
    if is_builtin(request.body) or wearer is None:
        return builtin_body(str(request.body))
    if request.body is not None and is_smpl(request.body):
        return load_smpl(Path(request.body))
    kept = kept_body(hooks)
    if kept is not None:
        return kept
    body = register_body(wearer.vertices, wearer.faces, cloth=pieces.cloth, name=wearer.name, hooks=hooks)
    keep_body(hooks, body)
    return body


def find_template(request: Request, target: Target) -> tuple[str, Pattern]:
    """Give the base pattern and its name: the given file, the named template, or the category's own."""
    if request.template is not None:
        return request.template.stem, load_pattern(request.template)
    name = request.settings.template
    if name is None:
        name = choose_template(target, [info.name for info in list_templates()])
    return name, load_template(name)


def check_category(name: str) -> str:
    """Give the category back if there is one of that name.

    Raises:
        SettingsBad: where there is none.
    """
    if name not in CATEGORIES:
        raise SettingsBad(f"garment '{name}' is not one of {', '.join(CATEGORIES)}.")
    return name


def measure(
    scan: Scan,
    target: Target,
    garment: Garment,
    detail: Deformation,
    simulation: np.ndarray | None,
    drape: Drape,
    wearer: WearerGeometry,
    settings: RecoverySettings,
    redraped: np.ndarray | None = None,
) -> dict[str, float | None]:
    """Measure all meshes against the scan; the truth is what the user gave."""
    metrics = measure_fit(
        garment,
        garment.nodes,
        detail.nodes,
        simulation,
        scan.vertices,
        scan.faces,
        target.contours,
        wearer.exposed,
        seed=settings.seed,
        redraped=redraped,
    )
    metrics |= measure_seams(garment.pattern)
    metrics["drape.residual"] = drape.residual
    metrics["drape.iterations"] = float(drape.iterations)
    metrics["drape.spin_rad_s"] = 0.0 if drape.rotation is None else drape.rotation.rate
    metrics["body.fit_rms_mm"] = 1e3 * wearer.body.fit_rms
    return metrics


def describe(request: Request, scan: Scan, body: Body, template: str, target: Target) -> dict[str, Any]:
    """Give what reproduces the result: versions, hashes, settings and what was understood of the input."""
    return {
        "versions": {name: _version(name) for name in PACKAGES} | {"python": platform.python_version()},
        "scan": {"name": scan.name, "sha256": scan.sha256, "units": scan.units, "up": scan.up_axis},
        "body": {"source": body.source, "fit_rms_m": float(np.round(body.fit_rms, 6))},
        "template": template,
        "category": target.category,
        "settings": request.settings.as_dict(),
    }


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
