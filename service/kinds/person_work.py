"""Segment a person in a job's process, and write the files of the result."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.body.spec import BuiltinWearer
from ...core.run.errors import BadInput
from .kind import RunContext
from .person_found import PersonFound
from .person_request import PERSON_INPUT_FILE, PersonRequest
from .recover_request import PERSON_REPORT_FILE, READING

if TYPE_CHECKING:
    from ...core.people.person_input import PersonInput
    from ...core.people.pipeline import SegmentedPerson
    from ...core.run.hooks import Hooks


def segment_person(request: PersonRequest, work: RunContext, hooks: Hooks) -> PersonFound:
    """Segment the person whose files a limited process has read, and write all files of the result.

    Raises:
        BadInput: if the scan is not a person's, or shows no clothes.
    """
    from ...core.people.person_input import load_person_input
    from ...core.people.pipeline import UnparsedHints
    from ...core.people.pipeline import segment_person as run
    from ..describe_person import describe_person
    from ..inspect_scan import explain_missing_body, is_garment_refusal

    content = load_person_input(work.files / PERSON_INPUT_FILE)
    builtin = request.body if isinstance(request.body, BuiltinWearer) else None
    try:
        apart = run(content, UnparsedHints(request.wearing, request.marks, builtin), hooks)
    except BadInput as error:
        if is_garment_refusal(error) and request.given_as is None and request.body is None:
            error.message = explain_missing_body(error)
        raise
    separation = apart.separation
    person = describe_person(apart.raw, separation)
    words = tuple(str(garment["part"]) for garment in person["garments"])
    metrics = measure_person(person, separation.body.fit_rms)
    warnings = tuple(dict.fromkeys((*apart.report.warnings, *_find_unused(request, words))))
    report = replace(apart.report, metrics=metrics, warnings=warnings)
    found = PersonFound(separation.body, person, report, separation.problem)
    _write(apart, content, found, work.out)
    return found


def measure_person(person: dict[str, Any], fit_rms: float) -> dict[str, float | None]:
    """Return the metrics by which a person can be found: the confidence of each garment, opening and the outfit."""
    metrics: dict[str, float | None] = {"body.fit_rms_mm": 1e3 * fit_rms, "garments": float(len(person["garments"]))}
    for garment in person["garments"]:
        metrics[f"confidence.{garment['part']}"] = garment["confidence"]
        for contour in garment["contours"]:
            metrics[f"confidence.{garment['part']}.{contour['name']}"] = contour["confidence"]
    return metrics


def _find_unused(request: PersonRequest, words: tuple[str, ...]) -> list[str]:
    """Return a warning for each choice for a garment that is not worn."""
    return [
        f"No garment was labelled {word}, so the choices for it were not used."
        for word in request.choices
        if word not in words
    ]


def _write(segmented: SegmentedPerson, content: PersonInput, found: PersonFound, folder: Path) -> None:
    from ...core.deliver.export.person import write_person
    from ...core.deliver.export.person_report import report_person
    from ...core.garment.reading import save_reading

    write_person(segmented.raw, segmented.separation, folder)
    report = report_person(
        segmented.raw, segmented.separation, found.report.warnings, (folder / "picture.png").read_bytes()
    )
    (folder / "report.html").write_text(report, encoding="utf-8")
    text = json.dumps(found.person | {"metrics": found.report.metrics}, indent=1, ensure_ascii=False)
    (folder / PERSON_REPORT_FILE).write_text(f"{text}\n", encoding="utf-8")
    for word, reading in segmented.readings.items():
        pattern = content.patterns.get(word)
        (folder / word).mkdir()
        save_reading(replace(reading, pattern=pattern or content.patterns.get("")), folder / word / READING)
