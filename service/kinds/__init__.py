"""The registered kinds of jobs, each a class that is loaded on first use, so that importing this package is cheap."""

from __future__ import annotations

from importlib import import_module

from ...core.run.errors import GarmentqError
from ..settings import ServiceSettings
from .kind import PARENT, ChildRequest, Kind, KindChange, Outcome, RunContext
from .request import FileRef, RequestBad, find_files, pack_request, read_request

__all__ = [
    "KINDS",
    "PARENT",
    "ChildRequest",
    "FileRef",
    "Kind",
    "KindChange",
    "KindUnknown",
    "Outcome",
    "RequestBad",
    "RunContext",
    "find_files",
    "find_kind",
    "pack_request",
    "read_request",
]  # fmt: skip

KINDS = {
    "recover": "garmentq.service.kinds.recover:Recover",
    "person": "garmentq.service.kinds.person:Person",
    "dress": "garmentq.service.kinds.dress:Dress",
    "outfit": "garmentq.service.kinds.outfit:Outfit",
    "refit": "garmentq.service.kinds.dress:Refit",
    "edit": "garmentq.service.kinds.edit:Edit",
    "animate": "garmentq.service.kinds.animate:Animate",
    "export": "garmentq.service.kinds.export:Export",
    "redrape": "garmentq.service.kinds.redrape:Redrape",
}
"""Dotted path of each kind's class by name."""


class KindUnknown(GarmentqError):
    """This kind of job is unknown here; set GARMENTQ_KINDS as where it was submitted, or upgrade this garmentq."""

    code = "job.kind_unknown"


def find_kind(settings: ServiceSettings, name: str) -> Kind:
    """Return the kind of a name, one of `KINDS` or of the dotted paths in GARMENTQ_KINDS.

    Raises:
        KindUnknown: if there is none.
    """
    if name in KINDS:
        return _load(KINDS[name])
    for path in filter(None, settings.kinds.split(",")):
        kind = _load(path.strip())
        if kind.name == name:
            return kind
    raise KindUnknown(f"this garmentq knows no kind of job '{name[:32]}'; {KindUnknown().message}")


def _load(path: str) -> Kind:
    module, _, name = path.partition(":")
    kind: Kind = getattr(import_module(module), name)()
    return kind
