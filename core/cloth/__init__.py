"""The cloth simulator: from a sewn garment, a fabric and a body to an equilibrium drape."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..run.lazy import import_lazily
from .fabric import Fabric, FabricEstimate
from .fabric_check import FabricNameBad, FabricOutOfRange, FabricSourceBad, check_fabric
from .fabric_file import FabricFileBad, FabricUnitBad, read_fabrics, write_fabrics
from .fabrics import DEFAULT_FABRIC, FabricUnknown, get_fabric, load_fabrics
from .locking import reduce_membrane_stiffness
from .outcome import Outcome
from .settings import (
    MAX_REST_RESIDUAL,
    STANDARD_GRAVITY,
    ContactSettings,
    SelfContactSettings,
    SettingsBad,
    SolveSettings,
)

if TYPE_CHECKING:
    from .bending_friction import BendingFriction
    from .block_pattern import BlockPattern
    from .collision.self_contact import SelfContact
    from .contact import contact_forces
    from .derivative import Derivative, FactoredEquilibrium, ImplicitDerivative, Response, linearise_at
    from .dynamics import ClothState, continue_time_steps, take_time_steps
    from .energy import Energy, Inertia
    from .friction import Friction, lag_friction
    from .layers import Layer, stack_garments
    from .linearised import LinearisedSteps
    from .parameters import Parameters, list_gathers, map_rest, stretch_edge
    from .pins import Pins, PinsBad
    from .rest import NotAtRest
    from .scene import Scene, SteadyRotation
    from .sensitivity import FABRIC_PARAMETERS, Sensitivity, fabric_forces, pull_forces, push_forces
    from .solver import Solver, SuperLU, make_solver
    from .statics import Drape, NodesBad, StopCallback, equilibrium
    from .steps import ClothTrajectory
    from .topology import Topology, TopologyBad
    from .unrolled import UnrolledSteps

_LAZY = {
    "FactoredEquilibrium": "derivative",
    "BendingFriction": "bending_friction",
    "BlockPattern": "block_pattern",
    "Derivative": "derivative",
    "Drape": "statics",
    "Energy": "energy",
    "FABRIC_PARAMETERS": "sensitivity",
    "Friction": "friction",
    "ImplicitDerivative": "derivative",
    "ClothTrajectory": "steps",
    "Inertia": "energy",
    "Layer": "layers",
    "LinearisedSteps": "linearised",
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
    "ClothState": "dynamics",
    "SteadyRotation": "scene",
    "StopCallback": "statics",
    "SuperLU": "solver",
    "Topology": "topology",
    "TopologyBad": "topology",
    "UnrolledSteps": "unrolled",
    "contact_forces": "contact",
    "equilibrium": "statics",
    "fabric_forces": "sensitivity",
    "lag_friction": "friction",
    "stack_garments": "layers",
    "linearise_at": "derivative",
    "list_gathers": "parameters",
    "make_solver": "solver",
    "map_rest": "parameters",
    "continue_time_steps": "dynamics",
    "pull_forces": "sensitivity",
    "push_forces": "sensitivity",
    "take_time_steps": "dynamics",
    "stretch_edge": "parameters",
}
# Their modules hold compiled kernels: imported on first use, so that the room itself stays light.

__all__ = [
    "DEFAULT_FABRIC",
    "FABRIC_PARAMETERS",
    "MAX_REST_RESIDUAL",
    "STANDARD_GRAVITY",
    "BendingFriction",
    "BlockPattern",
    "ClothState",
    "ClothTrajectory",
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
    "FactoredEquilibrium",
    "Friction",
    "ImplicitDerivative",
    "Inertia",
    "Layer",
    "LinearisedSteps",
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
    "SteadyRotation",
    "StopCallback",
    "SuperLU",
    "Topology",
    "TopologyBad",
    "UnrolledSteps",
    "check_fabric",
    "contact_forces",
    "continue_time_steps",
    "equilibrium",
    "fabric_forces",
    "get_fabric",
    "lag_friction",
    "linearise_at",
    "list_gathers",
    "load_fabrics",
    "make_solver",
    "map_rest",
    "pull_forces",
    "push_forces",
    "read_fabrics",
    "reduce_membrane_stiffness",
    "stack_garments",
    "stretch_edge",
    "take_time_steps",
    "write_fabrics",
]

__getattr__ = import_lazily(__name__, _LAZY)
