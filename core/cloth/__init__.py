"""The cloth simulator: from a sewn garment, a fabric and a body to an equilibrium drape."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..run.lazy import import_lazily
from .fabric import Fabric, FabricEstimate
from .fabric_check import FabricNameBad, FabricOutOfRange, FabricSourceBad, check_fabric
from .fabric_file import FabricFileBad, FabricUnitBad, read_fabrics, write_fabrics
from .fabrics import DEFAULT_FABRIC, FabricUnknown, get_fabric, load_fabrics
from .locking import soften
from .outcome import Outcome
from .settings import GRAVITY, RESTING, ContactSettings, SelfContactSettings, SettingsBad, SolveSettings

if TYPE_CHECKING:
    from .bending_friction import BendingFriction
    from .block_pattern import BlockPattern
    from .collision.self_contact import SelfContact
    from .contact import contact_forces
    from .derivative import AtRest, Derivative, Implicit, Response, linearise_at
    from .dynamics import State, move_on, settle
    from .energy import Energy, Inertia
    from .friction import Friction, lag_friction
    from .layers import Layer, lay_over
    from .linearised import Linearised
    from .parameters import Parameters, list_gathers, map_rest, stretch_edge
    from .pins import Pins, PinsBad
    from .rest import NotAtRest
    from .scene import Scene, SteadyRotation
    from .sensitivity import FABRIC, Sensitivity, fabric_forces, pull_forces, push_forces
    from .solver import Solver, SuperLU, make_solver
    from .statics import Drape, NodesBad, Stop, equilibrium
    from .steps import InMotion
    from .topology import Topology, TopologyBad
    from .unrolled import Unrolled

_LAZY = {
    "AtRest": "derivative",
    "BendingFriction": "bending_friction",
    "BlockPattern": "block_pattern",
    "Derivative": "derivative",
    "Drape": "statics",
    "Energy": "energy",
    "FABRIC": "sensitivity",
    "Friction": "friction",
    "Implicit": "derivative",
    "InMotion": "steps",
    "Inertia": "energy",
    "Layer": "layers",
    "Linearised": "linearised",
    "NodesBad": "statics",
    "NotAtRest": "rest",
    "Parameters": "parameters",
    "Pins": "pins",
    "PinsBad": "pins",
    "Response": "derivative",
    "Scene": "scene",
    "SelfContact": "collision.self_contact",
    "Sensitivity": "sensitivity",
    "Solver": "solver",
    "State": "dynamics",
    "SteadyRotation": "scene",
    "Stop": "statics",
    "SuperLU": "solver",
    "Topology": "topology",
    "TopologyBad": "topology",
    "Unrolled": "unrolled",
    "contact_forces": "contact",
    "equilibrium": "statics",
    "fabric_forces": "sensitivity",
    "lag_friction": "friction",
    "lay_over": "layers",
    "linearise_at": "derivative",
    "list_gathers": "parameters",
    "make_solver": "solver",
    "map_rest": "parameters",
    "move_on": "dynamics",
    "pull_forces": "sensitivity",
    "push_forces": "sensitivity",
    "settle": "dynamics",
    "stretch_edge": "parameters",
}
# Their modules hold compiled kernels: imported on first use, so that the room itself stays light.

__all__ = [
    "DEFAULT_FABRIC",
    "FABRIC",
    "GRAVITY",
    "RESTING",
    "AtRest",
    "BendingFriction",
    "BlockPattern",
    "ContactSettings",
    "Derivative",
    "Drape",
    "Energy",
    "Fabric",
    "FabricEstimate",
    "FabricFileBad",
    "FabricNameBad",
    "FabricOutOfRange",
    "FabricSourceBad",
    "FabricUnitBad",
    "FabricUnknown",
    "Friction",
    "Implicit",
    "InMotion",
    "Inertia",
    "Layer",
    "Linearised",
    "NodesBad",
    "NotAtRest",
    "Outcome",
    "Parameters",
    "Pins",
    "PinsBad",
    "Response",
    "Scene",
    "SelfContact",
    "SelfContactSettings",
    "Sensitivity",
    "SettingsBad",
    "SolveSettings",
    "Solver",
    "State",
    "SteadyRotation",
    "Stop",
    "SuperLU",
    "Topology",
    "TopologyBad",
    "Unrolled",
    "check_fabric",
    "contact_forces",
    "equilibrium",
    "fabric_forces",
    "get_fabric",
    "lag_friction",
    "lay_over",
    "linearise_at",
    "list_gathers",
    "load_fabrics",
    "make_solver",
    "map_rest",
    "move_on",
    "pull_forces",
    "push_forces",
    "read_fabrics",
    "settle",
    "soften",
    "stretch_edge",
    "write_fabrics",
]

__getattr__ = import_lazily(__name__, _LAZY)
