"""Find the cloth that hanging arms hide: no scan shows it, so it takes no closest points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...body.body import Body
from ...body.hanging_arms import lies_under_arm
from ...garment.garment import Garment
from .parts import find_parts


@dataclass(frozen=True)
class Armpits:
    """Describe which nodes of a worn garment are between the trunk and a hanging arm.

    Attributes:
        hidden: Nodes there, whose nearest surface of the scan is other cloth, shape [node_count].
        fixed: Those of them on seams between parts, such as the end of an armhole. They stay where they are worn, for
            the cloth between them and the visible cloth gives the lengths of side and sleeve, shape [node_count].
    """

    hidden: np.ndarray
    fixed: np.ndarray

    @classmethod
    def of(cls, garment: Garment, body: Body) -> Armpits:
        """Find them where the garment is worn now; none where no arm hangs."""
        hidden = lies_under_arm(garment.nodes, body)
        part = find_parts(garment.pattern)[garment.panel_of_uv]
        first, last = np.full(len(garment.nodes), len(part)), np.full(len(garment.nodes), -1)
        np.minimum.at(first, garment.uv_node, part)
        np.maximum.at(last, garment.uv_node, part)
        return cls(hidden, hidden & (first != last))
