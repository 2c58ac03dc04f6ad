"""The cloth simulator: from a sewn garment, a fabric and a body to an equilibrium drape."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .fabric import Fabric
from .fabrics import FabricUnknown, get_fabric, load_fabrics
from .settings import GRAVITY, SimulateSettings, SimulateSettingsBad

if TYPE_CHECKING:
    from .dynamics import State, settle
    from .energy import Energy, Inertia
    from .friction import Friction
    from .hold import Hold, HoldBad
    from .penetration import push_out
    from .solver import Solver, SuperLU, make_solver
    from .statics import Drape, NodesBad, equilibrium
    from .topology import Topology, TopologyBad

_LAZY = {
    "Drape": "statics",
    "Energy": "energy",
    "Friction": "friction",
    "Hold": "hold",
    "HoldBad": "hold",
    "Inertia": "energy",
    "NodesBad": "statics",
    "Solver": "solver",
    "State": "dynamics",
    "SuperLU": "solver",
    "Topology": "topology",
    "TopologyBad": "topology",
    "equilibrium": "statics",
    "make_solver": "solver",
    "push_out": "penetration",
    "settle": "dynamics",
}
# Their modules hold compiled kernels: imported on first use, so that the room itself stays light.

__all__ = [
    "GRAVITY",
    "Drape",
    "Energy",
    "Fabric",
    "FabricUnknown",
    "Friction",
    "Hold",
    "HoldBad",
    "Inertia",
    "NodesBad",
    "SimulateSettings",
    "SimulateSettingsBad",
    "Solver",
    "State",
    "SuperLU",
    "Topology",
    "TopologyBad",
    "equilibrium",
    "get_fabric",
    "load_fabrics",
    "make_solver",
    "push_out",
    "settle",
]


def __getattr__(name: str) -> Any:
    """Import a name's module when the name is first asked for."""
    if name in _LAZY:
        return getattr(importlib.import_module(f".{_LAZY[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
