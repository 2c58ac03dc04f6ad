"""Run the stages from a person's raw scan to one reading per garment."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..body.body import Body
from ..body.builtin import builtin_body
from ..body.dress_form import register_wearer
from ..body.spec import BuiltinWearer
from ..garment.reading import Reading
from ..run.clock import Clock
from ..run.hooks import SILENT_HOOKS, Hooks
from ..run.report import ResultReport
from ..scan.load import lies_on
from ..scan.raw import RawScan
from ..scan.refusal import BodyApart
from ..scan.scan import Scan
from .garments import build_person_surface, extract_garment
from .hints import Hints, parse_mark, parse_wearing
from .person_input import PersonInput
from .separate import label_person
from .separation import LabelledPerson

STAGES = ("body", "separate", "garments")
"""Stages after the reading of the files; progress and seconds are reported by these names."""


@dataclass(frozen=True)
class UnparsedHints:
    """Describe what the user gave beside a person's files.

    Attributes:
        wearing: Exactly these garments, `upper,lower`, or None.
        marks: What is at single places, `upper=0.1,1.2,0.05` each.
        body: A built-in body; None: from the files, or fitted to the scan.
    """

    wearing: str | None = None
    marks: tuple[str, ...] = ()
    body: BuiltinWearer | None = None


@dataclass(frozen=True)
class SegmentedPerson:
    """Describe a segmented person: the labels, and the input of each garment's recovery.

    Attributes:
        raw: The scan.
        separation: The labels.
        readings: By the garments' words; none of a garment that has a problem.
        report: Warnings and cost.
    """

    raw: RawScan
    separation: LabelledPerson
    readings: dict[str, Reading] = field(default_factory=dict)
    report: ResultReport = field(default_factory=ResultReport)


def segment_person(content: PersonInput, unparsed: UnparsedHints, hooks: Hooks = SILENT_HOOKS) -> SegmentedPerson:
    """Find the wearer, label the parts, and cut out each garment.

    Args:
        content: The content of the files.
        unparsed: What the user gave beside them.
        hooks: Progress, cancellation and checkpoints.

    Raises:
        BadInput: where the scan is no person, or shows no clothes.
    """
    clock, raw = Clock(hooks), content.raw
    with clock.stage("body", "finding the wearer") as stage:
        body = register_given_body(content, unparsed.body, stage)
    hints = Hints(
        label=content.label,
        wearing=None if unparsed.wearing is None else parse_wearing(unparsed.wearing),
        marks=tuple(parse_mark(text) for text in unparsed.marks),
        body=body,
    )
    with clock.stage("separate", "labelling skin, hair, shoes and garments") as stage:
        separation = label_person(raw, hints, stage)
    readings: dict[str, Reading] = {}
    with clock.stage("garments", "cutting out the garments") as stage:
        if separation.problem is None:
            readings = _cut_garments(raw, separation, stage)
    return SegmentedPerson(
        raw, separation, readings, ResultReport.of(clock, {}, (), (*raw.notes, *separation.warnings), {})
    )


def _cut_garments(raw: RawScan, separation: LabelledPerson, hooks: Hooks) -> dict[str, Reading]:
    """Cut every garment that can be recovered out of the person's surface, which is computed once."""
    surface = separation.surface or build_person_surface(raw, separation.body)
    readings: dict[str, Reading] = {}
    recovered = [garment for garment in separation.garments if garment.problem is None]
    for garment in recovered:
        hooks.progress("garments", len(readings) / len(recovered), garment.part.word)
        readings[garment.part.word] = extract_garment(surface, separation, garment.part, hooks)
    return readings


def register_given_body(content: PersonInput, builtin: BuiltinWearer | None, hooks: Hooks) -> Body | None:
    """Return the wearer that the user gave, in the scan's place; None where it has to be fitted under the clothes.

    Raises:
        BodyApart: where the scan is not on it.
    """
    body = content.body
    if builtin is not None:
        body = builtin_body(builtin)
    elif content.wearer is not None:
        wearer = content.wearer
        body = register_wearer(wearer.vertices, wearer.faces, name=wearer.name, hooks=hooks)
    if body is not None and not lies_on(content.raw.points, Scan(body.vertices, body.faces)):
        raise BodyApart("the person does not stand where the body is; export both from the same scene.")
    return body
