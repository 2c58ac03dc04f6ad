"""`/v1/templates`: the base patterns, shipped and imported."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request, Response
from starlette.concurrency import run_in_threadpool

from ..templates import TemplateNameBad, describe_templates, find_template, keep_template
from .access import Admin, Reader, Rooms, RoomsOf
from .answers import Imported, Templates
from .problems import show_answer
from .schemas import TemplateName

router = APIRouter(prefix="/templates", tags=["libraries"])

EXAMPLE = {"name": "skirt", "category": "skirt", "source": "shipped", "title": "Straight skirt"}
IMPORTED = {"name": "jacket", "panels": 7, "seams": 12, "category": "jacket"}


@router.get("", summary="List the templates.", responses=show_answer({"templates": [EXAMPLE]}, model=Templates))
def list_all(rooms: RoomsOf, caller: Reader) -> Any:
    """Give shipped and imported templates."""
    return {"templates": describe_templates(rooms.database)}


@router.get("/{name}", summary="Give a template as a GarmentCode pattern.", responses=show_answer({"pattern": {}}))
def show(name: TemplateName, rooms: RoomsOf, caller: Reader) -> Response:
    """Give the pattern file of a template."""
    from ...core.pattern import load_template, save_pattern

    kept = find_template(rooms.database, name)
    if kept:
        return Response(rooms.store.get_bytes(kept.sha256), media_type="application/json")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "template.json"
        save_pattern(load_template(name), path)
        return Response(path.read_bytes(), media_type="application/json")


@router.put(
    "/{name}", status_code=201, summary="Import a pattern file as a template.",
    responses=show_answer(IMPORTED, 201, Imported, (408, 507)),
    openapi_extra={
        "requestBody": {"required": True, "content": {"application/octet-stream": {"schema": {"type": "string"}}}}
    },
)  # fmt: skip
async def import_one(name: TemplateName, request: Request, rooms: RoomsOf, caller: Admin) -> Any:
    """Check a GarmentCode or NeuralTailor pattern file and keep it; one imported before under the name is replaced."""
    content = await request.body()
    return await run_in_threadpool(_import, rooms, name, content)


def _import(rooms: Rooms, name: str, content: bytes) -> dict[str, Any]:
    from ...core.pattern import list_templates, load_pattern

    if name in [info.name for info in list_templates()]:
        raise TemplateNameBad(f"'{name}' is the name of a shipped template; choose another.")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pattern.json"
        path.write_bytes(content)
        pattern = load_pattern(path)
        keep_template(rooms.database, rooms.store, name, path, pattern.category, len(pattern.panels))
    return {"name": name, "panels": len(pattern.panels), "seams": len(pattern.seams), "category": pattern.category}
