"""Internal friction of cloth in bending: a fold keeps its angle until the bending moment exceeds the friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .topology import Topology

BENDING_FRICTION_MOMENT = 1.5e-4
"""Friction moment of the yarns per length [N m/m]. Half of the width 2HB of the hysteresis loop of Kawabata's bending
tester, 0.03 gf cm/cm; assumed: light apparel cloth is usually reported at 0.02 to 0.1."""

HINGE_SLIP_ANGLE = 0.02
"""Turn of a hinge at which the friction is fully mobilised [rad]; below it friction is a spring, so that cloth at rest
does not creep. On edges of 2 cm it is a fold of 1 m radius, which is not visible."""

MAX_HELD_SLIP_RATIO = 2.0
"""Largest turn of a hinge at which its anchor angle stays [slip angles]; beyond it the anchor follows. 0.89 of the
moment is mobilised there; the smooth law approaches the whole moment asymptotically."""


@dataclass(frozen=True)
class BendingFriction:
    """Describe the yarns' friction in bending, which keeps the folds of the start.

        E_h = M |e| (sqrt(d^2 + s^2) - s),    d = theta - theta_a

    The moment never exceeds M |e| and opposes the turn away from the anchor angle theta_a. Without it an equilibrium
    drifts away from the folds it starts with, because the elastic energy changes by less than friction dissipates when
    folds move by centimetres (Miguel et al. 2013 measure and model it for bending, shear and stretch).

    Notation: `angles` theta_a; `moments` M |e|, |e| the flat length of the hinge's edge; `slip` s; theta as in
    `bending`. Derivatives take moments and angles as constants, as they take friction's limits and anchors.

    **Deviation**: the thesis has no such term; its 20 time steps end before folds have drifted.

    Attributes:
        angles: Anchor angle of each hinge [rad], shape [hinge_count].
        moments: Largest moment of each hinge [N m], shape [hinge_count].
        slip: Turn at which the moment is mobilised [rad].
    """

    angles: np.ndarray
    moments: np.ndarray
    slip: float = HINGE_SLIP_ANGLE

    @classmethod
    def at(cls, topology: Topology, nodes: np.ndarray, moment: float = BENDING_FRICTION_MOMENT) -> BendingFriction:
        """Compute the friction of a moment per length [N m/m], anchored at the folds of nodes [m], [node_count, 3]."""
        lengths = np.linalg.norm(topology.hinges.edges(topology.rest), axis=-1).mean(axis=0)
        return cls(measure_angles(topology, nodes), moment * lengths)

    def slide(self, angles: np.ndarray) -> np.ndarray:
        """Return the anchor angles [rad], shape [hinge_count], once hinges are at `angles` [rad]. The anchor of a hinge
        that is bent by more than `MAX_HELD_SLIP_RATIO` slips follows it: bending back and forth dissipates 2 M |e| per
        radian, as in the hysteresis loop of a bending tester."""
        bent = np.remainder(angles - self.angles + np.pi, 2.0 * np.pi) - np.pi
        limit = MAX_HELD_SLIP_RATIO * self.slip
        return np.asarray(angles - np.clip(bent, -limit, limit))


class FoldFriction(NamedTuple):
    """A `BendingFriction` as the bending's kernel takes it; moments are zero where there is none."""

    angles: np.ndarray
    moments: np.ndarray
    slip: float

    @classmethod
    def of(cls, topology: Topology, friction: BendingFriction | None = None) -> FoldFriction:
        """Return the friction in the hinges of a mesh, or none."""
        if friction is None:
            return cls(topology.hinges.angles, np.zeros(len(topology.hinges.nodes)), HINGE_SLIP_ANGLE)
        return cls(friction.angles, friction.moments, float(friction.slip))

    def among(self, hinges: slice) -> FoldFriction:
        """Return the friction of some of the hinges."""
        return FoldFriction(self.angles[hinges], self.moments[hinges], self.slip)


def measure_angles(topology: Topology, nodes: np.ndarray) -> np.ndarray:
    """Compute the angle between the normals of each hinge's faces [rad], signed as in `bending`, [hinge_count]."""
    start, end, first, second = (nodes[topology.hinges.nodes[:, n]] for n in range(4))
    edge = end - start
    before, after = np.cross(edge, first - start), np.cross(second - start, edge)
    sine = -np.linalg.norm(edge, axis=1) * (before * (second - start)).sum(1)
    return np.asarray(np.arctan2(sine, (before * after).sum(1)))
