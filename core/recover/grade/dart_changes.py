"""What is told of a dart that a recovery adds to its base pattern, or closes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LEAST_WIDTH = 0.01
"""Of a dart's mouth [m]: a narrower one is sewn less than 5 mm from its fold; a maker eases it into the seam."""


@dataclass(frozen=True)
class PanelChange:
    """Describe a dart that was added or closed, with the evidence for it.

    Attributes:
        kind: `added` or `closed`.
        panel: Name of the panel.
        edge: Label or contour of the edge that its mouth is on.
        mouth, apex: In the panel's axes [m].
        width: Of its mouth [m]; of one that was closed: what the scan asks for.
        before, after: Root mean square over the panel of the strain that no flat shape takes.
    """

    kind: str
    panel: str
    edge: str
    mouth: tuple[float, float]
    apex: tuple[float, float]
    width: float
    before: float
    after: float

    def tell(self) -> str:
        """Return the finding as one sentence with its evidence and its limit."""
        strain = f"{100 * self.before:.1f} to {100 * self.after:.1f} %"
        where = f"panel '{self.panel}' at '{self.edge}'"
        if self.kind == "added":
            length = float(np.linalg.norm(np.subtract(self.apex, self.mouth)))
            return (
                f"A dart of {1e3 * self.width:.0f} mm, {1e3 * length:.0f} mm long, was added to {where}: the strain "
                f"that no flat panel takes falls from {strain} there; --keep-cut leaves it out."
            )
        return (
            f"A dart of {where} was closed: the scan asks for {1e3 * self.width:.0f} mm, less than "
            f"{1e3 * LEAST_WIDTH:.0f}, and without it strain goes from {strain}; --keep-cut leaves it."
        )
