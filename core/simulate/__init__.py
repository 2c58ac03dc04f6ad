"""The cloth simulator: from a sewn garment, a fabric and a body to an equilibrium drape."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .fabric import Fabric, FabricEstimate
from .fabrics import FabricUnknown, get_fabric, load_fabrics
from .locking import soften
from .settings import GRAVITY, SimulateSettings, SimulateSettingsBad

if TYPE_CHECKING:
    from .bending_friction import BendingFriction
    from .derivative import AtRest, Derivative, Implicit, Response, linearise_at, with_friction_frozen
    from .dynamics import State, settle
    from .energy import Energy, Inertia, SteadyRotation
    from .friction import Friction
    from .linearised import Linearised
    from .newton import factor_blend
    from .parameters import Parameters, list_gathers, map_rest, stretch_edge
    from .pins import Pins, PinsBad
    from .rest import NotAtRest
    from .sensitivity import FABRIC, Sensitivity, fabric_forces, pull_forces, push_forces
    from .solver import Solver, SuperLU, make_solver
    from .statics import Drape, NodesBad, equilibrium
    from .steps import InMotion
    from .topology import Topology, TopologyBad
    from .unrolled import Unrolled

_LAZY = {
    "AtRest": "derivative",
    "BendingFriction": "bending_friction",
    "Derivative": "derivative",
    "Drape": "statics",
    "Energy": "energy",
    "FABRIC": "sensitivity",
    "Friction": "friction",
    "Implicit": "derivative",
    "InMotion": "steps",
    "Inertia": "energy",
    "Linearised": "linearised",
    "NodesBad": "statics",
    "NotAtRest": "rest",
    "Parameters": "parameters",
    "Pins": "pins",
    "PinsBad": "pins",
    "Response": "derivative",
    "Sensitivity": "sensitivity",
    "Solver": "solver",
    "State": "dynamics",
    "SteadyRotation": "energy",
    "SuperLU": "solver",
    "Topology": "topology",
    "TopologyBad": "topology",
    "Unrolled": "unrolled",
    "equilibrium": "statics",
    "fabric_forces": "sensitivity",
    "factor_blend": "newton",
    "linearise_at": "derivative",
    "list_gathers": "parameters",
    "make_solver": "solver",
    "map_rest": "parameters",
    "pull_forces": "sensitivity",
    "push_forces": "sensitivity",
    "settle": "dynamics",
    "stretch_edge": "parameters",
    "with_friction_frozen": "derivative",
}
# Their modules hold compiled kernels: imported on first use, so that the room itself stays light.

__all__ = [
    "FABRIC",
    "GRAVITY",
    "AtRest",
    "BendingFriction",
    "Derivative",
    "Drape",
    "Energy",
    "Fabric",
    "FabricEstimate",
    "FabricUnknown",
    "Friction",
    "Implicit",
    "InMotion",
    "Inertia",
    "Linearised",
    "NodesBad",
    "NotAtRest",
    "Parameters",
    "Pins",
    "PinsBad",
    "Response",
    "Sensitivity",
    "SimulateSettings",
    "SimulateSettingsBad",
    "Solver",
    "State",
    "SteadyRotation",
    "SuperLU",
    "Topology",
    "TopologyBad",
    "Unrolled",
    "equilibrium",
    "fabric_forces",
    "factor_blend",
    "get_fabric",
    "linearise_at",
    "list_gathers",
    "load_fabrics",
    "make_solver",
    "map_rest",
    "pull_forces",
    "push_forces",
    "settle",
    "soften",
    "stretch_edge",
    "with_friction_frozen",
]


def __getattr__(name: str) -> Any:
    """Import a name's module when the name is first asked for."""
    if name in _LAZY:
        return getattr(importlib.import_module(f".{_LAZY[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
