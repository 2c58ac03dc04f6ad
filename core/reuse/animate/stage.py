"""The scene of an animation: advance cloth and wearer by a step of time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...body.exposed import ExposedSurface
from ...body.motion.moving_body import MovingBody
from ...body.motion.track import LeadIn
from ...body.projection import project_outside
from ...body.skinning import skin, unskin, weights_at
from ...cloth.bending_friction import BendingFriction
from ...cloth.collision.self_contact import SelfContact
from ...cloth.dynamics import ClothState
from ...cloth.locking import reduce_membrane_stiffness
from ...cloth.motion_step import SolverLayout, StepResult, step_in_motion
from ...cloth.pins import Pins
from ...cloth.scene import Scene
from ...cloth.topology import Topology
from ...geometry.intersections import self_intersections
from ...recover.drape.waist_placement import pin_waist
from ..wear.worn import WornGarment
from .deliver import resolve_penetration
from .moving_skin import MovingSkin
from .settings import AnimateSettings, StepLimits
from .triangle_motion import move_anchors


@dataclass(frozen=True)
class Cloth:
    """Describe the cloth between two steps: positions and velocities, and the layout of the next step's matrix."""

    state: ClothState
    layout: SolverLayout


SKIN_MOTION_RADIUS = 0.03
"""Distance to the cloth within which the skin's motion limits a step [m]; skin beyond it does not reach the cloth."""


@dataclass(frozen=True)
class PosedWearer:
    """Describe the wearer at one time: `transforms` from rest space to the pose, shape [24, 4, 4], and exposed skin."""

    transforms: np.ndarray
    surface: ExposedSurface


@dataclass(frozen=True)
class AnimationScene:
    """Describe what is constant in an animation: the garment at the start, the wearer's motion, and the settings."""

    worn: WornGarment
    motion: LeadIn
    settings: AnimateSettings

    @cached_property
    def mover(self) -> MovingBody:
        """Return the wearer's body in any pose."""
        return MovingBody(self.worn.body)

    @cached_property
    def scene(self) -> Scene:
        """Return the scene without the body; the waist is pinned where it starts."""
        topology = Topology.from_garment(self.worn.garment)
        fabric = reduce_membrane_stiffness(self.worn.fabric)
        folds = BendingFriction.at(topology, self.worn.garment.nodes)
        return Scene(
            topology,
            fabric,
            None,
            pin_waist(self.worn.garment),
            None,
            folds,
            contact=self.settings.contact,
            self_contact=SelfContact.of(topology) if self.settings.self_contact else None,
        )

    @property
    def start(self) -> ClothState:
        """Return the cloth at rest in the garment's shape, with bending friction in its folds."""
        nodes, friction = np.array(self.worn.garment.nodes), self.scene.bending_friction
        assert friction is not None
        return ClothState(nodes, np.zeros_like(nodes), nodes.copy(), folds=friction.angles)

    @cached_property
    def layout(self) -> SolverLayout:
        """Return the matrix layout for the scene alone, with which a checkpoint's frames begin."""
        return SolverLayout.of(self.scene)

    @cached_property
    def weights(self) -> np.ndarray:
        """Return the skinning weights by which the wearer carries the cloth, shape [node_count, 24]."""
        return weights_at(self.worn.body, self.worn.garment.nodes, rest=False)

    @cached_property
    def _waist(self) -> np.ndarray:
        """Return the pinned nodes mapped back to the T-pose [m], shape [pin_count, 3]."""
        pins = self.scene.pins
        assert pins is not None
        return unskin(np.asarray(pins.points), self.weights[pins.nodes], self.worn.body.transforms)

    def at(self, time: float, nodes: np.ndarray) -> PosedWearer:
        """Return the wearer at a time of the motion [s], for queries near cloth at about `nodes` [m], [n, 3]."""
        transforms = self.mover.transforms(self.motion.at(time))
        vertices = skin(self.mover.at_rest, self.worn.body.weights, transforms)
        return PosedWearer(transforms, ExposedSurface(vertices, self.worn.body.faces, splits=0, measured=nodes))

    def move_pins(self, moment: PosedWearer) -> Pins | None:
        """Return the waist's pins carried by the skin and moved out of the body."""
        pins = self.scene.pins
        if pins is None:
            return None
        points = skin(self._waist, self.weights[pins.nodes], moment.transforms)
        return replace(pins, points=project_outside(points, moment.surface))

    def deliver(self, nodes: np.ndarray, moment: PosedWearer) -> np.ndarray:
        """Return a frame's nodes outside the wearer [m], shape [node_count, 3]; see `resolve_penetration`."""
        if self.scene.self_contact is None:
            return project_outside(nodes, moment.surface, self.worn.garment.faces)
        return resolve_penetration(nodes, moment.surface, self.scene)

    def count_steps(self, now: PosedWearer, nodes: np.ndarray, span: tuple[float, float], pace: StepLimits) -> int:
        """Return the number of steps for the wearer's motion between two times [s]; `now` is at the first."""
        later = self.mover.vertices(self.motion.at(span[1]))
        found = now.surface.closest(nodes)
        is_near = found.distance < SKIN_MOTION_RADIUS
        corners = now.surface.faces[found.face[is_near]]
        move = np.linalg.norm((later - now.surface.vertices)[corners].mean(axis=1), axis=1).max(initial=0.0)
        return max(1, int(np.ceil(move / pace.travel - 1e-9)), int(np.ceil((span[1] - span[0]) / pace.longest - 1e-9)))

    def step(self, cloth: Cloth, now: PosedWearer, then: PosedWearer, dt: float) -> StepResult:
        """Take a step of the cloth while the wearer moves from one moment to another in `dt` [s]."""
        state = cloth.state
        unposed = unskin(state.nodes, self.weights, now.transforms)
        carried = skin(unposed, self.weights, then.transforms)
        anchors = move_anchors(state.anchors, now.surface, then.surface.vertices)
        pins = self.move_pins(then)
        if pins is not None:
            carried[pins.nodes] = pins.points
        contact = self.scene.self_contact
        if contact is not None:
            contact = contact.wait(self_intersections(state.nodes, self.scene.topology.faces))
        layout = cloth.layout.at(pins, contact)
        start = ClothState(carried, state.velocities, anchors, folds=state.folds)
        return step_in_motion(layout, state, start, MovingSkin(then.surface), dt, self.settings.step)
