"""Take a person apart in a job's process, and write what is kept of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.body.spec import BuiltinWearer
from ...core.run.errors import BadInput
from .kind import Work
from .person_found import PersonFound
from .person_request import GIVEN, PersonRequest
from .recover_request import READING, TOLD

if TYPE_CHECKING:
    from ...core.people.given import Given
    from ...core.people.pipeline import Apart
    from ...core.run.hooks import Hooks


def take_apart(request: PersonRequest, work: Work, hooks: Hooks) -> PersonFound:
    """Take the person apart whose files a limited process has read, and write all files of the result.

    Raises:
        BadInput: where the scan is no person, or shows no clothes.
    """
    from ...core.people.describe import describe_person
    from ...core.people.given import load_given
    from ...core.people.inspect import explain_garment, is_no_person
    from ...core.people.pipeline import Wanted
    from ...core.people.pipeline import take_apart as run

    given = load_given(work.files / GIVEN)
    builtin = request.body if isinstance(request.body, BuiltinWearer) else None
    try:
        apart = run(given, Wanted(request.wearing, request.marks, builtin), hooks)
    except BadInput as error:
        if is_no_person(error) and request.given_as is None and request.body is None:
            error.message = explain_garment(error)
        raise
    separation = apart.separation
    person = describe_person(apart.raw, separation)
    words = tuple(str(garment["part"]) for garment in person["garments"])
    metrics = measure_person(person, separation.body.fit_rms)
    warnings = tuple(dict.fromkeys((*apart.report.warnings, *_find_unused(request, words))))
    report = replace(apart.report, metrics=metrics, warnings=warnings)
    found = PersonFound(separation.body, person, report, separation.problem)
    _write(apart, given, found, work.out)
    return found


def measure_person(person: dict[str, Any], fit_rms: float) -> dict[str, float | None]:
    """Return the numbers that a person can be found by: how sure each garment, opening and the outfit is."""
    metrics: dict[str, float | None] = {"body.fit_rms_mm": 1e3 * fit_rms, "garments": float(len(person["garments"]))}
    for garment in person["garments"]:
        metrics[f"confidence.{garment['part']}"] = garment["confidence"]
        for contour in garment["contours"]:
            metrics[f"confidence.{garment['part']}.{contour['name']}"] = contour["confidence"]
    return metrics


def _find_unused(request: PersonRequest, words: tuple[str, ...]) -> list[str]:
    """Return what the user said of garments that nobody wears."""
    return [
        f"Nothing was found to be {word}, so what was chosen for it was not used."
        for word in request.choices
        if word not in words
    ]


def _write(apart: Apart, given: Given, found: PersonFound, folder: Path) -> None:
    from ...core.deliver.export.person import write_person
    from ...core.deliver.export.person_report import report_person
    from ...core.garment.reading import save_reading

    write_person(apart.raw, apart.separation, folder)
    report = report_person(apart.raw, apart.separation, found.report.warnings, (folder / "picture.png").read_bytes())
    (folder / "report.html").write_text(report, encoding="utf-8")
    told = json.dumps(found.person | {"metrics": found.report.metrics}, indent=1, ensure_ascii=False)
    (folder / TOLD).write_text(f"{told}\n", encoding="utf-8")
    for word, reading in apart.readings.items():
        own = given.patterns.get(word)
        (folder / word).mkdir()
        save_reading(replace(reading, pattern=own or given.patterns.get("")), folder / word / READING)
