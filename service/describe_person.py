"""Describe a labelled person as JSON values, for the command line, the service and the report."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.people.limb_ends import third_probabilities
from ..core.people.part import Part
from ..core.people.separation import CategoryAlternative, FoundContour, FoundGarment, LabelledPerson, LimbEnd
from ..core.run.errors import GarmentqError
from ..core.scan.raw import RawScan


def describe_person(raw: RawScan, separation: LabelledPerson) -> dict[str, Any]:
    """Return garments, readings, body and warnings of a labelled person."""
    values, counts = np.unique(separation.label[raw.place >= 0], return_counts=True)
    return {
        "scan": {
            "name": raw.name,
            "sha256": raw.sha256,
            "units": raw.units,
            "up": raw.up_axis,
            "is_cloud": raw.is_cloud,
            "point_count": len(raw.points),
            "face_count": len(raw.faces),
            "notes": list(raw.notes),
        },
        "body": {"source": separation.body.source, "fit_rms_m": round(float(separation.body.fit_rms), 6)},
        "parts": {Part(value).word: count for value, count in zip(values.tolist(), counts.tolist(), strict=True)},
        "garments": [describe_garment(garment) for garment in separation.garments],
        "outfits": [
            {"parts": [part.word for part in outfit.parts], "score": round(outfit.score, 3)}
            for outfit in separation.outfits
        ],
        "warnings": list(separation.warnings),
        "problem": _describe_problem(separation.problem),
    }


def describe_garment(garment: FoundGarment) -> dict[str, Any]:
    """Return one garment's category, confidence, openings, and why it is not recovered or None."""
    return {
        "part": garment.part.word,
        "category": garment.category,
        "alternative": _describe_alternative(garment.alternative),
        "confidence": round(garment.confidence, 4),
        "contours": [_describe_contour(contour) for contour in garment.contours],
        "problem": _describe_problem(garment.problem),
    }


def _describe_problem(problem: GarmentqError | None) -> dict[str, str] | None:
    return None if problem is None else {"code": problem.code, "message": problem.message}


def _describe_contour(contour: FoundContour) -> dict[str, Any]:
    """Return where a garment ends, and half the width of its 0.9 interval; none where it is hidden and not known."""
    interval = None if contour.interval is None else round(1e3 * contour.interval, 1)
    found = {"name": contour.name, "confidence": round(contour.confidence, 4), "is_inferred": contour.is_inferred}
    return found | {"interval_mm": interval} | _describe_limb_end(contour.limb_end)


def _describe_limb_end(end: LimbEnd | None) -> dict[str, Any]:
    """Return how far along its limb a sleeve or leg ends, and the probabilities of the limb's thirds."""
    if end is None:
        return {}
    thirds = [round(one, 3) for one in third_probabilities(end)]
    return {"limb_share": round(end.limb_share, 3), "third_probabilities": thirds}


def _describe_alternative(other: CategoryAlternative | None) -> dict[str, Any] | None:
    return None if other is None else {"category": other.category, "probability": round(other.probability, 3)}
