"""Edges of a panel as commands of an SVG path."""

from __future__ import annotations

import numpy as np

from .pattern import Edge


def edge_path(edge: Edge, drawn: np.ndarray) -> str:
    """Return the SVG path command of an edge.

    Args:
        edge: Its kind.
        drawn: Start, handles and end on the page [mm, y down], shape [2 + handle_count, 2].
    """
    end = _pair(drawn[-1])
    if edge.kind == "quadratic":
        return f"Q {_pair(drawn[1])} {end}"
    if edge.kind == "cubic":
        return f"C {_pair(drawn[1])} {_pair(drawn[2])} {end}"
    if edge.kind == "arc" and abs(edge.handles[0, 1]) > 1e-9:
        height = float(edge.handles[0, 1])
        chord = float(np.linalg.norm(drawn[-1] - drawn[0]))
        radius = chord * (0.25 + height * height) / (2.0 * abs(height))
        # An apex to the left of the chord makes a clockwise arc, which is SVG's sweep 1 on a page with y down.
        return f"A {radius:.6f} {radius:.6f} 0 {int(abs(height) > 0.5)} {int(height > 0)} {end}"
    return f"L {end}"


def _pair(point: np.ndarray) -> str:
    return f"{point[0]:.6f} {point[1]:.6f}"
