"""garmentq: a 3D scan of a garment goes in, a sewing pattern, a simulation mesh and a detailed mesh come out.

import garmentq
job = garmentq.Client("http://127.0.0.1:8080").recover("scan.ply").wait()
job.pattern.panels
result = garmentq.open_result("result/upper")
result.mesh("detail").vertices
result.plot()
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .service.async_client import AsyncClient
    from .service.client import Client
    from .service.opening import open_result

__version__ = "0.2.0"
__all__ = ["AsyncClient", "Client", "__version__", "open_result"]

PLACES = {
    "AsyncClient": ".service.async_client",
    "Client": ".service.client",
    "open_result": ".service.opening",
}
"""The module of each name."""


def __getattr__(name: str) -> Any:
    """Import what is asked for when it is first asked for, so that the package itself stays light."""
    if name in PLACES:
        return getattr(import_module(PLACES[name], __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return all names, those too that are imported when they are first asked for."""
    return sorted({*globals(), *__all__})
