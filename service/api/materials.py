"""`/v1/materials`: the fabric library."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from ..catalogue import read_fabric, show_fabric
from ..materials import delete_material, keep_materials, list_materials, read_material
from .access import Admin, AppStateDependency, Reader
from .answers import Material, Materials
from .problems import RequestBad, show_answer, show_list
from .schemas import FabricIn, FabricName, Text

router = APIRouter(prefix="/materials", tags=["libraries"])

EXAMPLE = {
    "name": "denim", "title": "Denim", "density": 0.4, "thickness": 0.0008, "friction": 0.5, "H00": 1000.0,
    "H01": 100.0, "H11": 900.0, "H22": 300.0, "k": 1e-5, "sources": {"density": "measured"},
}  # fmt: skip


@router.get(
    "", name="list_materials", summary="List the fabrics.",
    responses=show_answer(show_list("materials", [EXAMPLE]), model=Materials),
)  # fmt: skip
def list_all(rooms: AppStateDependency, caller: Reader) -> Any:
    """Return every fabric, shipped and imported, in SI units."""
    return show_list("materials", [show_fabric(fabric) for fabric in list_materials(rooms.database)])


@router.get("/{name}", summary="Show a fabric.", responses=show_answer(EXAMPLE, model=Material))
def show_material(name: Text, rooms: AppStateDependency, caller: Reader) -> Any:
    """Return one fabric, with the source of every number."""
    return show_fabric(read_material(rooms.database, name))


@router.put(
    "/{name}", status_code=201, summary="Import a fabric.", responses=show_answer(EXAMPLE, 201, Material, (408,))
)
def import_material(name: FabricName, payload: FabricIn, rooms: AppStateDependency, caller: Admin) -> Any:
    """Check a fabric in SI units and store it; an imported fabric of the same name is replaced."""
    from ...core.cloth.fabric_check import check_fabric

    if payload.name != name:
        raise RequestBad("the fabric's name differs from the name in the address; use one name.")
    fabric = check_fabric(read_fabric(payload.model_dump()))
    keep_materials(rooms.database, [fabric])
    return show_fabric(fabric)


@router.delete(
    "/{name}", name="delete_material", summary="Delete an imported fabric.",
    responses=show_answer(EXAMPLE, model=Material),
)  # fmt: skip
def delete(name: Text, rooms: AppStateDependency, caller: Admin) -> Any:
    """Delete an imported fabric; jobs that use it keep its numbers."""
    return show_fabric(delete_material(rooms.database, name))
