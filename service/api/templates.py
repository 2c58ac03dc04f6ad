"""`/v1/templates`: the base patterns, shipped and imported."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request, Response

from ...core.limited import IsStopped
from ..catalogue import ImportedTemplate, Template
from ..templates import delete_template, import_template, list_templates, read_template
from .access import Admin, Reader, Rooms, RoomsOf
from .answers import Templates
from .problems import show_answer
from .schemas import TemplateName

router = APIRouter(prefix="/templates", tags=["libraries"])

EXAMPLE = {"name": "skirt", "category": "skirt", "source": "shipped", "title": "Straight skirt"}
IMPORTED = {"name": "jacket", "panels": 7, "seams": 12, "category": "jacket"}
DELETED = {"name": "jacket", "category": "jacket", "source": "imported", "title": "7 panels"}


@router.get("", summary="List the templates.", responses=show_answer({"templates": [EXAMPLE]}, model=Templates))
def list_all(rooms: RoomsOf, caller: Reader) -> Any:
    """Return shipped and imported templates."""
    return {"templates": list_templates(rooms.database)}


@router.get("/{name}", summary="Give a template as a GarmentCode pattern.", responses=show_answer({"pattern": {}}))
def show(name: TemplateName, rooms: RoomsOf, caller: Reader) -> Response:
    """Return the pattern file of a template."""
    return Response(read_template(rooms, name), media_type="application/json")


@router.put(
    "/{name}", status_code=201, summary="Import a pattern file as a template.",
    responses=show_answer(IMPORTED, 201, ImportedTemplate, (408, 507)),
    openapi_extra={
        "requestBody": {"required": True, "content": {"application/octet-stream": {"schema": {"type": "string"}}}}
    },
)  # fmt: skip
async def import_one(name: TemplateName, request: Request, rooms: RoomsOf, caller: Admin) -> Any:
    """Check a GarmentCode or NeuralTailor pattern file and keep it; one imported before under the name is replaced."""
    content = await request.body()
    return await rooms.limited.run(request, caller.key, partial(_import, rooms, name, content))


@router.delete("/{name}", summary="Delete an imported template.", responses=show_answer(DELETED, model=Template))
def delete_one(name: TemplateName, rooms: RoomsOf, caller: Admin) -> Any:
    """Delete an imported template; jobs that were asked for with it keep its file."""
    return delete_template(rooms.database, name)


def _import(rooms: Rooms, name: str, content: bytes, is_stopped: IsStopped) -> ImportedTemplate:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pattern.json"
        path.write_bytes(content)
        return import_template(rooms, name, path, is_stopped)
