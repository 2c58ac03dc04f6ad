"""Records of base patterns and fabrics, read from a home or from a service's JSON response."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar

from .records import CLOSED, Json, JsonRecord

if TYPE_CHECKING:
    from ..core.cloth.fabric import Fabric


@dataclass(frozen=True)
class Template(JsonRecord):
    """Describe a base pattern: `source` is `shipped` or `imported`."""

    __pydantic_config__: ClassVar = CLOSED
    name: str
    category: str
    source: str
    title: str


@dataclass(frozen=True)
class ImportedTemplate(JsonRecord):
    """Describe an imported pattern."""

    __pydantic_config__: ClassVar = CLOSED
    name: str
    panels: int
    seams: int
    category: str


def show_fabric(fabric: Fabric) -> dict[str, Any]:
    """Return a fabric as JSON values: every parameter in SI units, and the source of each."""
    return {**asdict(fabric), "sources": dict(fabric.sources)}


def read_fabric(found: Json) -> Fabric:
    """Read a service's response."""
    from ..core.cloth.fabric import Fabric

    known = {item.name: found[item.name] for item in fields(Fabric)}
    return Fabric(**{**known, "sources": tuple((str(n), str(v)) for n, v in found["sources"].items())})
