"""garmentq: a 3D scan of a garment goes in, a sewing pattern, a simulation mesh and a detailed mesh come out.

import garmentq
result = garmentq.open_result("result/upper")
result.mesh("detail").vertices
result.plot()
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .service.opening import open_result

__version__ = "0.2.0"
__all__ = ["__version__", "open_result"]


def __getattr__(name: str) -> Any:
    """Import what is asked for when it is first asked for, so that the package itself stays light."""
    if name == "open_result":
        from .service.opening import open_result

        return open_result
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return all names, those too that are imported when they are first asked for."""
    return sorted({*globals(), *__all__})
