"""`/v1/patterns/check`, `/v1/patterns/edit`: check and change a pattern's document before it is draped."""

from __future__ import annotations

import json
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request

from ...core.run.sandbox import IsStopped
from ..patterns import edit_pattern, examine_pattern
from .access import AppStateDependency, Reader
from .answers import PatternCheck, PatternEdited
from .problems import show_answer
from .schemas import SQUARE, DocumentIn, PatternEditIn

router = APIRouter(prefix="/patterns", tags=["editing"])

EXAMPLE = {
    "is_sound": True,
    "findings": [{
        "code": "pattern.seam_unequal", "severity": "warning", "seam": 5,
        "message": "the sides of seam 5 differ by 3.0 mm (420.0 and 423.0 mm); make them equal, or mark the seam as "
        "gathered.",
        "places": [
            {"panel": "back", "edge": 8, "vertex": None, "point": None},
            {"panel": "front", "edge": 0, "vertex": None, "point": None},
        ],
    }],
    "panels": [{"panel": "front", "area_cm2": 2894.1, "edges_mm": [423.0, 200.7, 107.7, 115.2]}],
    "seams": [{
        "a": {"panel": "back", "edge": 8}, "b": {"panel": "front", "edge": 0}, "lengths_mm": [420.0, 423.0],
        "mismatch_mm": -3.0, "is_gathered": False,
    }],
    "mirrors": [{
        "source": "front", "target": "front", "vertices": [[3, 0], [2, 1], [1, 2], [0, 3]],
        "matrix": [[-1.0, 0.0], [0.0, 1.0]],
    }],
}  # fmt: skip


@router.post(
    "/check", summary="Check a pattern and locate its faults.",
    responses=show_answer(EXAMPLE, model=PatternCheck, refusals=(408,)),
)  # fmt: skip
async def check_pattern(document: DocumentIn, request: Request, rooms: AppStateDependency, caller: Reader) -> Any:
    """Check a GarmentCode or NeuralTailor document: outlines, seams, mesh; nothing is stored.

    `is_sound` is false if a finding of severity `error` keeps the pattern from being draped. Edges, control points and
    seams have the document's numbers, points its unit.
    """

    def work(is_stopped: IsStopped) -> Any:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "pattern.json"
            path.write_text(json.dumps(document.model_dump()), encoding="utf-8")
            return examine_pattern(path, is_stopped)

    return await rooms.limited.run(request, caller.key, work)


@router.post(
    "/edit", name="edit_pattern", summary="Change a pattern by operations.",
    responses=show_answer({"pattern": SQUARE, **EXAMPLE}, model=PatternEdited, refusals=(408,)),
)  # fmt: skip
async def edit(payload: PatternEditIn, request: Request, rooms: AppStateDependency, caller: Reader) -> Any:
    """Apply operations to a document one after the other, and check the new one; nothing is stored.

    An operation that cannot be applied is refused with its number, and with its place in `findings`.
    docs/reference/http.md describes each operation and its fields.
    """
    work = partial(edit_pattern, payload.pattern.model_dump(), payload.operations)
    return await rooms.limited.run(request, caller.key, work)
