"""`/v1/materials`: the fabric library."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from ..catalogue import show_fabric
from .access import Reader
from .answers import Material, Materials
from .problems import show_answer
from .schemas import Text

router = APIRouter(prefix="/materials", tags=["libraries"])

EXAMPLE = {
    "name": "denim", "title": "Denim", "density": 0.4, "thickness": 0.0008, "friction": 0.5, "H00": 1000.0,
    "H01": 100.0, "H11": 900.0, "H22": 300.0, "k": 1e-5, "sources": {"density": "measured"},
}  # fmt: skip


@router.get("", summary="List the fabrics.", responses=show_answer({"materials": [EXAMPLE]}, model=Materials))
def list_all(caller: Reader) -> Any:
    """Return every fabric in SI units."""
    from ...core.simulate import load_fabrics

    return {"materials": [show_fabric(fabric) for fabric in load_fabrics()]}


@router.get("/{name}", summary="Show a fabric.", responses=show_answer(EXAMPLE, model=Material))
def show(name: Text, caller: Reader) -> Any:
    """Return one fabric, with the source of every number."""
    from ...core.simulate import get_fabric

    return show_fabric(get_fabric(name))
