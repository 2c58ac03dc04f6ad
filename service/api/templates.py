"""`/v1/templates`: the base patterns, shipped and imported."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request, Response

from ...core.run.sandbox import IsStopped
from ..catalogue import ImportedTemplate, Template
from ..templates import delete_template, import_template, list_templates, read_template
from .access import Admin, AppState, AppStateDependency, Reader
from .answers import Templates
from .problems import BYTES, show_answer, show_list
from .schemas import SQUARE, DocumentIn, TemplateName

router = APIRouter(prefix="/templates", tags=["libraries"])

EXAMPLE = {"name": "skirt", "category": "skirt", "source": "shipped", "title": "Straight skirt"}
IMPORTED = {"name": "jacket", "panels": 7, "seams": 12, "category": "jacket"}
DELETED = {"name": "jacket", "category": "jacket", "source": "imported", "title": "7 panels"}


@router.get(
    "", name="list_templates", summary="List the templates.",
    responses=show_answer(show_list("templates", [EXAMPLE]), model=Templates),
)  # fmt: skip
def list_all(rooms: AppStateDependency, caller: Reader) -> Any:
    """Return shipped and imported templates."""
    return show_list("templates", list_templates(rooms.database))


@router.get(
    "/{name}", summary="Return a template as a GarmentCode pattern.",
    responses=show_answer(SQUARE, model=DocumentIn),
)  # fmt: skip
def show_template(name: TemplateName, rooms: AppStateDependency, caller: Reader) -> Response:
    """Return the pattern file of a template."""
    return Response(read_template(rooms, name), media_type="application/json")


@router.put(
    "/{name}", status_code=201, name="import_template", summary="Import a pattern file as a template.",
    responses=show_answer(IMPORTED, 201, ImportedTemplate, (408, 507)),
    openapi_extra={
        "requestBody": {"required": True, "content": {"application/octet-stream": {"schema": BYTES}}}
    },
)  # fmt: skip
async def import_one(name: TemplateName, request: Request, rooms: AppStateDependency, caller: Admin) -> Any:
    """Check a GarmentCode or NeuralTailor pattern file and store it; an imported one of the same name is replaced."""
    content = await request.body()
    return await rooms.limited.run(request, caller.key, partial(_import, rooms, name, content))


@router.delete(
    "/{name}", name="delete_template", summary="Delete an imported template.",
    responses=show_answer(DELETED, model=Template),
)  # fmt: skip
def delete_one(name: TemplateName, rooms: AppStateDependency, caller: Admin) -> Any:
    """Delete an imported template; jobs that use it keep its file."""
    return delete_template(rooms.database, name)


def _import(rooms: AppState, name: str, content: bytes, is_stopped: IsStopped) -> ImportedTemplate:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pattern.json"
        path.write_bytes(content)
        return import_template(rooms, name, path, is_stopped)
