"""Judge a result: each gate compares one number with a limit that has a reason, and says what to do next."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum

from ..cloth.settings import MAX_REST_RESIDUAL
from ..people.undeclared import MAX_SKIN_OFFSET_RMS
from ..run.verdict import Gate, Verdict

Metrics = Mapping[str, float | None]


class Product(StrEnum):
    """Describe what of a result is judged: a drape in unrest says nothing about the detail mesh."""

    DETAIL = "detail"
    PATTERN = "pattern"
    DRAPE = "drape"


@dataclass(frozen=True)
class GateRule:
    """Describe how one gate is judged.

    Attributes:
        name: Name of the gate.
        value: Reads the judged value from the metrics, or None where it was not measured.
        doubtful: Above this the result is doubtful.
        fail: Above this it fails.
        what: What is measured, with `{value}` in it.
        next_step: What the user should do about it.
        reason: Why the limits are where they are.
        product: What of the result is judged.
    """

    name: str
    value: Callable[[Metrics], float | None]
    doubtful: float
    fail: float
    what: str
    next_step: str
    reason: str
    product: Product = Product.DETAIL


def _read_metric(name: str) -> Callable[[Metrics], float | None]:
    return lambda metrics: metrics.get(name)


def _read_doubt(name: str) -> Callable[[Metrics], float | None]:
    """Read a probability, and return that of the contrary."""

    def value(metrics: Metrics) -> float | None:
        found = metrics.get(name)
        return None if found is None else 1.0 - found

    return value


def _read_delivered_drapes(name: str, join: Callable[[list[float]], float]) -> Callable[[Metrics], float | None]:
    """Read a metric of the drapes that are delivered; of the graded one where the method makes no other."""

    def value(metrics: Metrics) -> float | None:
        for drapes in (("sim", "redrape"), ("drape",)):
            found = [value for drape in drapes if (value := metrics.get(f"{drape}.{name}")) is not None]
            if found:
                return join(found)
        return None

    return value


def _max_or_nan(found: list[float]) -> float:
    """Return the largest of some numbers; one that is none is larger than all."""
    return max(found, key=lambda value: (value != value, value))


def _count_not_at_rest(found: list[float]) -> float:
    """Count the drapes that are not at rest, from 1 for each that is."""
    return float(sum(value != 1.0 for value in found))


def _read_larger_distance(name: str) -> Callable[[Metrics], float | None]:
    """Read a distance that is measured both ways: the larger one."""

    def value(metrics: Metrics) -> float | None:
        ways = [one for one in (metrics.get(f"{name}.s2t"), metrics.get(f"{name}.t2s")) if one is not None]
        return max(ways) if ways else None

    return value


def _read_largest(prefix: str, suffix: str) -> Callable[[Metrics], float | None]:
    """Read the largest of the metrics whose names begin and end so."""

    def value(metrics: Metrics) -> float | None:
        found = [metrics[name] for name in metrics if name.startswith(prefix) and name.endswith(suffix)]
        known = [number for number in found if number is not None]
        return max(known) if known else None

    return value


def _percent_of_faces(name: str, excluded: str = "") -> Callable[[Metrics], float | None]:
    """Read a count as per cent of all faces, what another count had already left out."""

    def value(metrics: Metrics) -> float | None:
        count, faces = metrics.get(name), metrics.get("faces")
        if count is None or not faces:
            return None
        return 100.0 * max(0.0, count - ((metrics.get(excluded) or 0.0) if excluded else 0.0)) / faces

    return value


def _read_excess_stretch(name: str, other: str) -> Callable[[Metrics], float | None]:
    """Read a stretch; 1 where another mesh of the same cloth is as stretched, and cloth can be."""

    def value(metrics: Metrics) -> float | None:
        stretch, by = metrics.get(name), metrics.get(other)
        return (
            stretch
            if stretch is None or by is None or stretch > EQUAL_STRETCH_RATIO * min(by, MAX_KNIT_STRETCH)
            else 1.0
        )

    return value


EQUAL_STRETCH_RATIO, MAX_KNIT_STRETCH = 1.05, 1.5
"""Largest ratio at which one stretch counts as equal to another, since the thousandth face of two meshes is not the
same face; and the largest stretch that cloth has (stretched length over length as cut), a knit's. Beyond it the other
mesh is at fault."""

GATE_RULES = (
    GateRule(
        "surface_fit_s2t", _read_metric("surface_rms_mm.s2t"), 2.5, 10.0,
        "The detail mesh lies {value:.1f} mm (RMS) from the scan",
        "look at the error map: the template may lack a part that the scan has; try another with --template.",
        "2.5 mm is a good scanner's noise and the cloth's thickness; at 10 mm the folds are other ones.",
    ),
    GateRule(
        "surface_fit_t2s", _read_metric("surface_rms_mm.t2s"), 4.0, 15.0,
        "The scan lies {value:.1f} mm (RMS) from the detail mesh",
        "part of the scan has no counterpart: cut away what is not the garment, or choose a template with --template.",
        "Wider than the other way, since deep folds that a 1.5 cm mesh bridges count here; 15 mm means a missing part.",
    ),
    GateRule(
        "hidden", _read_metric("hidden_percent"), 10.0, 50.0,
        "{value:.0f} % of the garment lies where the scan does not show it",
        "its pattern is the base pattern's there; give a closer one with --template, or scan the garment uncovered.",
        "A waistband under a top's hem is 8 % of trousers; from half on the base pattern says more than the scan does.",
        Product.PATTERN,
    ),
    GateRule(
        "ends", _read_metric("inferred_ends"), 0.5, 4.0,
        "Nothing shows where {value:.0f} of the sleeves or legs end",
        "compare their lengths with the garment; mark the ends in labels.npz, or give a --template.",
        "One end that is cut by guess may not be sold; the other limb or the base pattern gave it.",
        Product.PATTERN,
    ),
    GateRule(
        "sides", _read_metric("wear.sides_mm"), 40.0, 150.0,
        "Left and right sleeve or leg of a symmetric cut end {value:.0f} mm apart",
        "look where the shorter one ends: its rest may be labelled as skin or shoe; mend labels.npz and give --labels.",
        "Of five scanned persons sleeves that are cut alike hung up to 33 mm apart, legs 3; 15 cm is a forearm's half.",
    ),
    GateRule(
        "seams", _read_metric("seam_mismatch_mm"), 0.5, 3.0,
        "The two sides of a seam differ by up to {value:.2f} mm in length",
        "ease the longer side in when sewing, or grade again from another template.",
        "Grading keeps 0.1 mm; 3 mm (1/8 inch) is the sewing tolerance of industry specifications.",
        Product.PATTERN,
    ),
    GateRule(
        "fairness", _read_metric("pattern.corner_deg"), 5.0, 30.0,
        "The pattern has a corner of {value:.0f} degrees where its base pattern is smooth",
        "smooth the curve before you cut; where the garment has such a corner, give a closer pattern with --template.",
        "A knife does not show 5 degrees; 30 degrees across a seam is a notch in the hem.",
        Product.PATTERN,
    ),
    GateRule(
        "pointed", _read_metric("pattern.pointed_corner_deg"), 60.0, 80.0,
        "A panel's corner comes to a point, {value:.0f} degrees below a right angle, as the base pattern's does not",
        "crumpled cloth says little of its shape there; choose another part with --part, or hold lengths with --lock.",
        "The narrowest corner of right patterns is 39 degrees, 51 below; in a sleeve torn to a point 15, and 75 below.",
        Product.PATTERN,
    ),
    GateRule(
        "neckline", _read_metric("shape.neck_corner_deg"), 30.0, 60.0,
        "The corners of the pattern's neckline and of the scan's differ by {value:.0f} degrees",
        "it is of another kind: choose it with --part neckline=v, or crew, scoop, square, boat; or back_neckline.",
        "Right necklines differ by 3 to 13 degrees, a crew neck from the V of two scans by 100 and 115.",
        Product.PATTERN,
    ),
    GateRule(
        "edge_corners", _read_metric("shape.edge_corner_deg"), 25.0, 60.0,
        "The scan's hem or another edge has a corner of {value:.0f} degrees that the pattern's has not",
        "seams may end there that the pattern lacks, as between gores; give a closer pattern with --template.",
        "Right patterns lack 12 degrees at most, circles in place of eight gores 41 and 42; 60 is a slit or a point.",
        Product.PATTERN,
    ),
    GateRule(
        "collar", _read_metric("shape.collar_cm2"), 100.0, 200.0,
        "The scan has {value:.0f} cm2 more cloth turned over at its neck than the pattern's collar",
        "choose its collar with --part collar=shirt, or convertible, polo, notched, shawl.",
        "Right collars differ by a quarter of their area, 60 cm2; a shirt's fall that is missing has 250.",
        Product.PATTERN,
    ),
    GateRule(
        "neck_finish", _read_doubt("cut.collar_probability"), 0.15, 1.0,
        "What is sewn to the neck is another collar, a hood or nothing with a probability of {value:.2f}",
        "look at the neck in the report, and choose with --part collar=none, shirt, stand, or hood=two.",
        "Of drapes whose collar was 0.85 likely nine in ten were right, of less likely ones half. Never fails.",
        Product.PATTERN,
    ),
    GateRule(
        "contour_shape", _read_largest("shape.", "_mm"), 40.0, 100.0,
        "An open edge of the drape runs up to {value:.0f} mm away from the scan's",
        "look at neck, hem and cuffs in the report: a part is of another kind, or hangs another way; try --part.",
        "Edges of right patterns hang 5 to 30 mm off, a crew neck cut for a V 36; 100 mm is another length or part.",
        Product.PATTERN,
    ),
    GateRule(
        "plausible", _read_metric("pattern.beyond_human"), 1.0, 1.5,
        "The most unusual length or opening of the pattern is {value:.1f} of the limit of what humans wear",
        "check the units with --units, and that the scan is a garment in the size of its body.",
        "The ranges hold babies and the largest sizes sold; half as much again is a doll, or a wrong unit.",
        Product.PATTERN,
    ),
    GateRule(
        "penetration", _read_metric("body_penetration_mm"), 1.0, 5.0,
        "The garment lies up to {value:.1f} mm inside the body",
        "check that body and scan belong together and share units and place; garmentq inspect shows both.",
        "Under 1 mm nothing shows in a render; scans touch their bodies up to 5 mm deep, more is a misplaced body.",
    ),
    GateRule(
        "undeclared", _read_metric("body.undeclared_mm"), 1e3 * MAX_SKIN_OFFSET_RMS, 50.0,
        "What looks like a garment but was taken for skin lies {value:.0f} mm (RMS) off the body",
        "the body was fitted to it and is too wide there; name what is cloth with --cloth, see the remarks.",
        "`MAX_SKIN_OFFSET_RMS` says where skin ends; 50 mm add 30 cm to a girth.",
    ),
    GateRule(
        "pinched", _read_metric("pinched_mm"), 5.0, 25.0,
        "Parts of the body that run into each other hold cloth up to {value:.1f} mm inside both",
        "give a body whose limbs do not lie in each other, or fit it anew; the cloth between them is a guess.",
        "Thighs and arms that touch yield by some millimetres, true cloth lies 3 mm deep there; 25 mm is a wrong pose.",
    ),
    GateRule(
        "flips", _percent_of_faces("flipped_faces"), 0.5, 3.0,
        "{value:.2f} % of the faces point against the scan",
        "look for inside-out folds in the error map; a higher --vertices resolves tight folds better.",
        "Where two layers touch, the closest one is a toss-up, which costs some 0.5 %; 3 % is a turned region.",
    ),
    GateRule(
        "self_intersections",
        _percent_of_faces("self_intersecting_faces", excluded="graded.self_intersecting_faces"), 0.5, 3.0,
        "{value:.2f} % of the faces pass through others and did not before deforming",
        "repair the scan where it intersects itself, or simulate on the simulation mesh instead of the detail mesh.",
        "A scan's own contacts leave a few faces; from 3 % on a simulator will not start from this mesh.",
    ),
    GateRule(
        "simulation_fit", _read_larger_distance("sim.surface_rms_mm"), 15.0, 30.0,
        "The simulation mesh lies {value:.1f} mm (RMS) from the scan, or the scan from it",
        "its folds fall elsewhere than the scan's; use the detail mesh where the shape counts.",
        "Folds of one full circle differ by up to 15 mm in two drapes; at 30 mm it hangs or stands out another way.",
        Product.DRAPE,
    ),
    GateRule(
        "rest", _read_metric("wear.rest_gap_mm"), 25.0, 50.0,
        "The uppermost cloth stays {value:.0f} mm away from the body",
        "nothing bears it there; check that the scan is a garment, worn by this body, in its place.",
        "Worn cloth lies on shoulders or waist, 1 to 5 mm away; padding adds 2 or 3 cm; curtains and balls had 88 mm.",
    ),
    GateRule(
        "layers", _read_metric("wear.layers"), 1.3, 1.6,
        "The scan has {value:.1f} times the area of the detail mesh",
        "it has several layers, or parts that the template lacks; give the outer layer alone, or another template.",
        "Pockets, facings and ruffles add up to a third; from 1.6 on more than half of the garment is there twice.",
    ),
    GateRule(
        "upright", _read_metric("wear.waist_by_hem"), 1.0, 1.25,
        "The waist is {value:.2f} times as long as the hem",
        "turn the scan over if it hangs upside down, or check --up.",
        "A waist bears and a hem leaves room to step: skirts have 0.3 to 0.8, a hem drawn together at the knees 1.2.",
    ),
    GateRule(
        "redrape", _read_metric("redrape_missing"), 0.0, 1.0,
        "The pattern has not been dressed anew from its flat panels",
        "wait for the re-drape's job or retry it, or recover with --redrape wait; the field `redrape` shows its state.",
        "Whether flat panels give the garment is known only after they were sewn; nothing is known to be wrong.",
        Product.DRAPE,
    ),
    GateRule(
        "redrape_fit", _read_larger_distance("redrape.surface_rms_mm"), 20.0, 40.0,
        "The pattern dressed anew from its flat panels lies {value:.1f} mm (RMS) from the scan",
        "look at the re-draped mesh: what was sewn from this pattern may hang another way than what was scanned.",
        "True patterns of foreign drapes come within 5 to 20 mm, full skirts 18; at 40 mm a part hangs elsewhere.",
        Product.DRAPE,
    ),
    GateRule(
        "redrape_stretch", _read_excess_stretch("redrape.stretch_p999", "stretch_p999"), 1.3, 2.0,
        "One triangle of a thousand of the re-draped mesh is stretched {value:.2f} times",
        "a cuff or waist is caught or too tight: start from the detail mesh, or dress the pattern on a wider body.",
        "Woven cloth tears at 1.2 to 1.3, knits bear 1.5, and what the scan shows stretched is; torn cuffs had 8.",
        Product.DRAPE,
    ),
    GateRule(
        "redrape_intersections", _percent_of_faces("redrape.self_intersecting_faces"), 0.5, 3.0,
        "{value:.2f} % of the faces of the re-draped mesh pass through others",
        "simulate on the simulation mesh, or drape again in another pose.",
        "As for the detail mesh: a few faces where layers touch; from 3 % on a simulator will not start from it.",
        Product.DRAPE,
    ),
    GateRule(
        "drape_residual", _read_delivered_drapes("residual", _max_or_nan), MAX_REST_RESIDUAL, 100.0,
        "The least balanced node of the drapes feels {value:.1f} times a node's weight",
        "that drape is not at rest; settle it before simulating on. The detail mesh is judged by the surface fit.",
        "`MAX_REST_RESIDUAL` says why cloth rests below it; 100 is the pull of tight cloth that slides.",
        Product.DRAPE,
    ),
    GateRule(
        "at_rest", _read_delivered_drapes("at_rest", _count_not_at_rest), 0.0, 2.0,
        "Of the drapes that are delivered {value:.0f} are not at rest",
        "the remarks say which, and why; simulate on from another mesh, or recover anew with other --vertices.",
        "A search that gave up or is stuck ends somewhere; there are two drapes at most, and the detail mesh is none.",
        Product.DRAPE,
    ),
)  # fmt: skip
"""Every gate, in the order of the report."""


def product_of(gate: str) -> Product:
    """Return what a gate judges, by the gate's name; the detail mesh where no rule has that name."""
    return next((rule.product for rule in GATE_RULES if rule.name == gate), Product.DETAIL)


def evaluate_gates(metrics: Metrics) -> tuple[Gate, ...]:
    """Judge the metrics of a result; a gate whose number was not measured is left out."""
    gates = []
    for rule in GATE_RULES:
        value = rule.value(metrics)
        if value is None:
            continue
        # Written so that a value which is no number fails.
        verdict = Verdict.FAIL
        if value <= rule.fail:
            verdict = Verdict.PASS if value <= rule.doubtful else Verdict.DOUBTFUL
        what = rule.what.format(value=value)
        message = f"{what}." if verdict is Verdict.PASS else f"{what}: {rule.next_step}"
        gates.append(Gate(rule.name, verdict, float(value), rule.fail, message))
    return tuple(gates)
