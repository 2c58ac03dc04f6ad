"""The lines of a summary about a segmented person."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..service.outfit_readings import list_readings, name_category, name_end
from ..service.records import JobReport

UNSURE_OPENING_COUNT = 2
"""Number of openings that are named: those with the least confidence."""


def describe_person(job: JobReport) -> Iterator[tuple[str, str]]:
    """Yield the lines about a person as title and text: scan, body, outfit, garments and their confidence."""
    found = job.details
    yield "scan", f"{job.name}; {_describe_scan(found.get('checked') or {})}"
    fit = job.metrics.get("body.fit_rms_mm")
    yield "body", f"{job.body or 'not known'}" + ("" if fit is None else f"; {fit:.1f} mm RMS from the visible skin")
    yield "wears", describe_outfits(found.get("outfits") or [])
    garments = found.get("garments") or []
    yield "garments", "; ".join(_describe_garment(garment) for garment in garments) or "none"
    yield "openings", describe_openings(garments)
    made = ", ".join(f"{child.name} ({child.job}, {child.state})" for child in job.children)
    yield "made", made or "nothing"


def describe_outfits(outfits: Sequence[Mapping[str, Any]]) -> str:
    """Return the best reading of the outfit, and the second, with their probabilities among all readings."""
    shown = [f"{one.words} ({one.percent})" for one in list_readings(outfits)[:2]]
    return "; or ".join(shown) or "not known"


def describe_openings(garments: Sequence[Mapping[str, Any]]) -> str:
    """Return the inferred openings, and of the shown ones those with the least confidence."""
    found = [(garment["part"], contour) for garment in garments for contour in garment["contours"]]
    inferred = [f"{part} {name_end(contour)}" for part, contour in found if contour["is_inferred"]]
    seen = sorted((c["confidence"], f"{part} {name_end(c)}") for part, c in found if not c["is_inferred"])
    texts = [f"{name} {probability:.2f}" for probability, name in seen[:UNSURE_OPENING_COUNT]]
    unseen = f"; inferred: {', '.join(inferred)}" if inferred else ""
    least = f"{len(seen)} shown" + (f", least confidence: {', '.join(texts)}" if texts else "")
    return least + unseen


def _describe_garment(garment: Mapping[str, Any]) -> str:
    category = f" ({name_category(garment)})" if garment.get("category") else ""
    left = ", not recovered" if garment.get("problem") else ""
    return f"{garment['part']}{category}, confidence {garment['confidence']:.2f}{left}"


def _describe_scan(checked: Mapping[str, Any]) -> str:
    scan = checked.get("scan") or {}
    if "vertex_count" not in scan:
        return "not read yet" if not scan else f"in {scan.get('units', 'm')}"
    what = "cloud" if scan["is_cloud"] else "mesh"
    colours = "with" if scan["has_colours"] else "without"
    return f"{what} of {scan['vertex_count']} points {colours} colours, {scan['units']}, {scan['up']} up"
