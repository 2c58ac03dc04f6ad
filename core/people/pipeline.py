"""The stages from a person's raw scan to one reading per garment, in their order."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..body import Body, BuiltinWearer, builtin_body, register_body
from ..garment.reading import Reading
from ..run.clock import Clock
from ..run.hooks import SILENT, Hooks
from ..run.report import ResultReport
from ..scan import Scan, lies_on
from ..scan.raw import RawScan
from ..scan.refusal import BodyApart
from .garments import cut_garment_of, find_surface
from .given import Given
from .hints import Hints, parse_mark, parse_wearing
from .separate import separate
from .separation import Separation

STAGES = ("body", "separate", "garments")
"""The stages beside the reading of the files; progress and seconds are reported by these names."""


@dataclass(frozen=True)
class Wanted:
    """What the user says of a person beyond the files.

    Attributes:
        wearing: Exactly these garments, `upper,lower`, or None.
        marks: What is at single places, `upper=0.1,1.2,0.05` each.
        body: A built-in body, or None: the files tell, or the scan.
    """

    wearing: str | None = None
    marks: tuple[str, ...] = ()
    body: BuiltinWearer | None = None


@dataclass(frozen=True)
class Apart:
    """A person taken apart, and what each garment's recovery starts from.

    Attributes:
        raw: The scan.
        separation: What each point is.
        readings: By the garments' words; empty where the separation has a problem.
        report: Warnings and cost.
    """

    raw: RawScan
    separation: Separation
    readings: dict[str, Reading] = field(default_factory=dict)
    report: ResultReport = field(default_factory=ResultReport)


def take_apart(given: Given, wanted: Wanted, hooks: Hooks = SILENT) -> Apart:
    """Find the wearer, tell the parts apart, and cut out each garment.

    Args:
        given: What the files hold.
        wanted: What the user says.
        hooks: Progress, cancellation and checkpoints.

    Raises:
        BadInput: where the scan is no person, or shows no clothes.
    """
    clock, raw = Clock(hooks), given.raw
    with clock.stage("body", "finding the wearer") as stage:
        body = find_wearer(given, wanted.body, stage)
    hints = Hints(
        label=given.label,
        wearing=None if wanted.wearing is None else parse_wearing(wanted.wearing),
        marks=tuple(parse_mark(text) for text in wanted.marks),
        body=body,
    )
    with clock.stage("separate", "telling skin, hair, shoes and garments apart") as stage:
        separation = separate(raw, hints, stage)
    readings: dict[str, Reading] = {}
    with clock.stage("garments", "cutting out the garments") as stage:
        if separation.problem is None:
            readings = _cut_garments(raw, separation, stage)
    return Apart(raw, separation, readings, ResultReport.of(clock, {}, (), (*raw.notes, *separation.warnings), {}))


def _cut_garments(raw: RawScan, separation: Separation, hooks: Hooks) -> dict[str, Reading]:
    """Cut every garment out of the person's surface, which is made once where the scan is a cloud."""
    surface = find_surface(raw, separation.body)
    readings: dict[str, Reading] = {}
    for garment in separation.garments:
        hooks.progress("garments", len(readings) / len(separation.garments), garment.part.word)
        readings[garment.part.word] = cut_garment_of(surface, separation, garment.part, hooks)
    return readings


def find_wearer(given: Given, builtin: BuiltinWearer | None, hooks: Hooks) -> Body | None:
    """Return the wearer that the user gave, in the scan's place; None where he is to be found under the clothes.

    Raises:
        BodyApart: where the scan does not lie on it.
    """
    body = given.body
    if builtin is not None:
        body = builtin_body(builtin)
    elif given.wearer is not None:
        wearer = given.wearer
        body = register_body(wearer.vertices, wearer.faces, name=wearer.name, hooks=hooks)
    if body is not None and not lies_on(given.raw.points, Scan(body.vertices, body.faces)):
        raise BodyApart("the person does not stand where the body is; export both from the same scene.")
    return body
