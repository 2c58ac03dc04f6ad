"""Find the grainline of panels from where they lie on the body: upright on trunk and legs, along the arm on sleeves."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from .curves import edge_length
from .panel_parts import ARM_PARTS, find_arm_panels, find_part
from .pattern import EdgeRef, Panel, Pattern
from .seams import find_sewn_partners

GRAIN_UNKNOWN_KEY = "grain_unknown"
"""Key in `Pattern.extra` of the names of the panels whose grainline nobody knows."""

MIN_UPRIGHT_PANEL_COSINE = np.cos(np.radians(45.0))
"""Smallest cosine between a panel's plane and the vertical at which its warp is upright (45 degrees); a panel that lies
flatter, such as the crown of a hood, does not show its warp by its place."""

MIN_ARM_RUN_SHARE = 0.25
"""Smallest distance between both ends of a sleeve as a share of its panel's diagonal; where its ends are nearer, its
seams do not show the direction of the arm."""


def place_grains(pattern: Pattern, known: Collection[str] = ()) -> Pattern:
    """Return a pattern with the grainlines of its panels by their places; `list_unknown_grains` gives those that have
    none.

    Args:
        pattern: The pattern, its panels placed on the body.
        known: Names of panels whose grainline is given and stays.
    """
    arms = find_arm_panels(pattern)
    panels, unknown = [], []
    for panel in pattern.panels:
        up = None if panel.name in known else _find_warp(pattern, panel, arms)
        if up is not None:
            panel = replace(panel, grainline=float(np.arctan2(-up[0], up[1])) + 0.0)
        elif panel.name not in known:
            unknown.append(panel.name)
        panels.append(panel)
    extra = {key: value for key, value in pattern.extra.items() if key != GRAIN_UNKNOWN_KEY}
    return replace(pattern, panels=tuple(panels), extra=extra | ({GRAIN_UNKNOWN_KEY: unknown} if unknown else {}))


def list_unknown_grains(pattern: Pattern) -> frozenset[str]:
    """Return the names of the panels whose grainline neither file nor place shows."""
    return frozenset(map(str, pattern.extra.get(GRAIN_UNKNOWN_KEY, ())))


def _find_warp(pattern: Pattern, panel: Panel, arms: dict[str, int]) -> np.ndarray | None:
    """Return the direction of a panel's warp towards the head or the shoulder, shape [2]; None where nothing shows it.

    Args:
        pattern: The pattern.
        panel: One of its panels.
        arms: Number of seams from the trunk of each panel on an arm.
    """
    if not _is_placed(pattern):
        return None
    if panel.name in arms:
        along = _find_arm_direction(pattern, panel, arms)
        if along is not None or find_part(panel) in ARM_PARTS:
            return along
    up = (panel.rotation.T @ [0.0, 1.0, 0.0])[:2]
    return up if np.linalg.norm(up) > MIN_UPRIGHT_PANEL_COSINE else None


def _is_placed(pattern: Pattern) -> bool:
    """Check whether a file places its panels: several panels in one place are none that a body could wear."""
    places = [np.concatenate([panel.translation, panel.rotation.ravel()]) for panel in pattern.panels]
    return len(places) > 1 and bool(np.ptp(places, axis=0).max() > 1e-6)


def _find_arm_direction(pattern: Pattern, panel: Panel, arms: dict[str, int]) -> np.ndarray | None:
    """Return the direction from a sleeve panel's end near the hand to that near the trunk [m], shape [2]; None where
    its seams do not show both."""
    partners = find_sewn_partners(pattern)
    ends: dict[bool, list[tuple[float, np.ndarray]]] = {True: [], False: []}
    for i in range(len(panel.points)):
        partner = partners.get(EdgeRef(panel.name, i))
        depth = np.inf if partner is None else arms.get(partner.panel, 0)
        if depth != arms[panel.name]:
            middle = (panel.points[i] + panel.points[(i + 1) % len(panel.points)]) / 2.0
            ends[depth < arms[panel.name]].append((edge_length(panel, i), middle))
    if not ends[True] or not ends[False]:
        return None
    near, far = (
        np.average([middle for _, middle in ends[side]], axis=0, weights=[length for length, _ in ends[side]])
        for side in (True, False)
    )
    run = near - far
    diagonal = float(np.linalg.norm(np.ptp(panel.points, axis=0)))
    return run if np.linalg.norm(run) > MIN_ARM_RUN_SHARE * diagonal else None
