"""What was understood of a job's files, in the rows of the form that submits them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..records import JobReport
from ..submission import PERSON_KIND
from .garment_words import title_garment
from .markup import Html, html, join

KINDS = {"person": "a whole person", "garment": "a garment"}
"""What a scan is detected as, in words."""

CHECKED = "checked"
"""Key of a job's details under which its first stage describes the files."""


def draw_facts(job: JobReport) -> Html:
    """Return the card with what was detected in a job's files; hidden while nothing is known."""
    rows = join(html("<tr><th scope=row>{}</th><td>{}</td></tr>", name, text) for name, text in list_facts(job))
    return html(CARD, hidden=Html() if rows else Html(" hidden"), rows=rows)


def list_facts(job: JobReport) -> list[tuple[str, str]]:
    """Return the names and texts of what was detected in a job's files."""
    checked = job.details.get(CHECKED)
    found: Mapping[str, Any] = checked if isinstance(checked, Mapping) else {}
    parts = job.details.get("parts") if job.kind == PERSON_KIND else None
    rows = [*_read_scan(found)]
    if isinstance(parts, Mapping) and parts:
        counts = ", ".join(f"{name} {_count(number)}" for name, number in parts.items())
        rows.append(("Points by part", counts))
    return rows


def _read_scan(found: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the facts of the scan; a fact that the stored description has not is left out."""
    scan, body = found.get("scan"), found.get("body")
    if found.get("as") in KINDS:
        yield "Detected as", KINDS[found["as"]]
    if isinstance(scan, Mapping):
        yield from _describe_scan(scan)
    if isinstance(body, Mapping) and (height := body.get("height_m") or [*body.get("extent_m", []), 0, 0][1]):
        yield "Wearer", f"{height:.2f} m tall"
    if found.get("category"):
        yield "Garment", title_garment(str(found["category"]))
    openings = found.get("contours_m")
    if isinstance(openings, Mapping) and openings:
        yield "Openings", ", ".join(f"{name} {length:.2f} m" for name, length in openings.items())
    if isinstance(scan, Mapping) and (repairs := scan.get("notes") or scan.get("repairs")):
        yield "Repaired", " ".join(map(str, repairs))
    if found.get("doubts"):
        yield "Doubtful", " ".join(map(str, found["doubts"]))


def _describe_scan(scan: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    if scan.get("extent_m"):
        size = " × ".join(f"{length:.2f}" for length in scan["extent_m"])
        yield "Size", f"{size} m, {scan.get('up')} of the file is up, its unit is {scan.get('units')}"
    if scan.get("vertex_count") is not None:
        count, in_file = int(scan["vertex_count"]), int(scan.get("file_count") or 0)
        dropped = f", of {_count(in_file)} in the file" if in_file > count else ""
        points = f"{_count(count)} points{dropped}"
        faces = f"{points}, {_count(scan.get('face_count') or 0)} faces"
        yield "Surface", f"a cloud of {points}" if scan.get("is_cloud") else faces
    if scan.get("has_colours") is not None:
        labels = {None: "", True: ", labels", False: ", no labels"}[scan.get("has_labels")]
        yield "Attributes", ("colours" if scan["has_colours"] else "no colours") + labels


def _count(number: int) -> str:
    return f"{int(number):,}"


CARD = """<section class="card" id="understood"{hidden}><h2>Detected in the files</h2>
<div class="wide"><table>{rows}</table></div></section>"""
